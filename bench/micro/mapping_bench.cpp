// Rods along tiles against rods across them: lone rods of 1000, 200 and 50 elements, and rods of 5 to 100 elements in one scene, each
// beside eight equal rods (as many tiles as the mixed scene has, in that case) of as many elements. Steps as of the cilia; medians of
// interleaved turns; results of both mappings agree in every bit, which is checked.
//   bench_mappings [turns]
#include "measure.hpp"
#include "support/scenes_for_tests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace {

using namespace skein;

struct Contender {
    std::string name;
    std::unique_ptr<test::Stage> stage;
    std::int64_t batch;
    std::vector<double> ns; ///< per element-step, one per turn

    void run(double seconds_worth) {
        const double elements = static_cast<double>(stage->plan.elements);
        const auto steps = std::max<std::int64_t>(64, static_cast<std::int64_t>(seconds_worth / (elements * 15e-9)) / 64 * 64);
        const double before = bench::core_seconds();
        stage->advance(stage->clock.done() + steps, batch);
        ns.push_back((bench::core_seconds() - before) * 1e9 / (elements * static_cast<double>(steps)));
    }
    double median() {
        std::sort(ns.begin(), ns.end());
        return ns[ns.size() / 2];
    }
};

SceneSpec cilia(long count, long elements) {
    SceneSpec scene = test::cilia_scene(count, elements);
    scene.time.dt = 1e-5; // stable for all lengths here
    return scene;
}

/// `count` rods of every length from 5 to 100 elements.
SceneSpec mixed(long count) {
    SceneSpec scene = cilia(count, 5);
    const RodSpec one = scene.rods[0];
    scene.rods.clear();
    for (long n = 5; n <= 100; ++n) {
        scene.rods.push_back(one);
        scene.rods.back().name = fmt::format("rods of {}", n);
        scene.rods.back().shape.elements = n;
        scene.rods.back().shape.length = 0.06 * static_cast<double>(n);
    }
    return scene;
}

Contender contender(std::string name, const SceneSpec& scene, std::int64_t batch, Mapping mapping = Mapping::automatic) {
    return {std::move(name), std::make_unique<test::Stage>(scene, 8, 1, mapping), batch, {}};
}

} // namespace

int main(int argc, char** argv) {
    const int turns = argc > 1 ? std::max(1, std::atoi(argv[1])) : 9;
    for (const long n : {1000L, 200L, 100L, 50L, 20L}) {
        test::Stage across(cilia(1, n), 1), along(cilia(1, n), 8, 1, Mapping::along);
        across.advance(100), along.advance(100);
        if (across.rods->digest() != along.rods->digest()) return fmt::print("lone rod of {}: bits differ\n", n), 1;
    }
    test::Stage across(mixed(1), 1), automatic(mixed(1));
    across.advance(100), automatic.advance(100);
    if (across.rods->digest() != automatic.rods->digest()) return fmt::print("mixed lengths: bits differ\n"), 1;

    fmt::print("{:<46}{:>8}{:>14}{:>8}\n", "", "ns", "block's ns", "ratio");
    for (const std::int64_t batch : {std::int64_t{1}, std::int64_t{64}}) {
        std::vector<std::pair<Contender, Contender>> pairs;
        for (const long n : {1000L, 200L, 50L})
            pairs.emplace_back(contender(fmt::format("lone rod of {}, {} steps per visit", n, batch), cilia(1, n), batch), contender("", cilia(8, n), batch));
        for (const long count : {1L, 2L, 4L, 8L, 20L})
            pairs.emplace_back(contender(fmt::format("5 to 100 elements, {} of each, {} steps per visit", count, batch), mixed(count), batch),
                               contender("", cilia(96 * count, 52), batch));
        for (int turn = 0; turn < turns; ++turn)
            for (auto& [one, block] : pairs) one.run(0.05), block.run(0.05);
        for (auto& [one, block] : pairs) {
            const double a = one.median(), b = block.median();
            fmt::print("{:<46}{:>8.2f}{:>14.2f}{:>8.2f}\n", one.name, a, b, a / b);
        }
    }
    return 0;
}
