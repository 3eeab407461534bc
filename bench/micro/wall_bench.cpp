// What six walls cost per element: rods in the middle of a box, and rods that lie on its floor with every node; beside
// the elastic pass.
//   names: <case>/W<width>/n<elements>/<level>
#include "contact/wall_pass.hpp"
#include "micro/working_set.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

namespace {

using namespace skein;
using namespace skein::bench;

constexpr double radius = 0.02, half_side = 5;

std::vector<Wall> box(ContactFriction friction) {
    Wall box;
    box.name = "box";
    box.kind = WallKind::box;
    box.lower = {-half_side, -half_side, -half_side};
    box.upper = {half_side, half_side, half_side};
    box.law = {.normal = ContactNormal::hertz,
               .stiffness = 1e5,
               .damping = 10,
               .friction = friction,
               .static_friction = 0.4,
               .kinetic_friction = 0.2};
    return {box};
}

enum class Case { elastic, none_near, all_on_floor, all_on_floor_without_friction };
constexpr const char* names[] = {"elastic", "walls-none-near", "walls-all-on-floor",
                                 "walls-all-on-floor-without-friction"};

template <int W> void run(benchmark::State& state, Case which, long n, double bytes) {
    RodSpec spec = test::simple_rod(n);
    spec.placement.tangent = {1, 0, 0};
    const bool lies = which == Case::all_on_floor || which == Case::all_on_floor_without_friction;
    spec.placement.origin = {0, 0, lies ? radius - half_side - 1e-3 : 0};
    const RodGroup group(spec, 0, 0, "");
    WorkingSet<W> set(group, bytes);
    const auto walls = std::make_shared<Walls>(
        box(which == Case::all_on_floor_without_friction ? ContactFriction::none : ContactFriction::memory));
    const auto contacts = std::make_shared<WallContactTiles<W>>(*walls, group);
    std::unique_ptr<TilePass<W>> pass;
    if (which == Case::elastic) pass = std::make_unique<ElasticPass<IncompressibleLaw, W>>(Ends{});
    else pass = std::make_unique<WallPass<W>>(walls, group, contacts);
    for (const RodTile<W>& tile : set.tiles()) pass->bind(tile);
    Clock clock(1e-5, 1);
    const auto steps = clock.next(2);
    pass->prepare(steps);
    for (auto _ : state) {
        for (const RodTile<W>& tile : set.tiles()) pass->run(tile, set.load(), steps[0]);
        benchmark::ClobberMemory();
    }
    if (lies && contacts->figures({0, 0}, walls->find("box z-")).touching != static_cast<double>(n) + 1)
        state.SkipWithError("not all nodes touch");
    state.counters["per element"] =
        benchmark::Counter(set.elements(), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

template <int W> void add() {
    for (const Level& level : {levels[1], levels[2]})
        for (int which = 0; which < 4; ++which)
            benchmark::RegisterBenchmark(
                fmt::format("{}/W{}/n20/{}", names[which], W, level.name).c_str(),
                [=](benchmark::State& state) { run<W>(state, static_cast<Case>(which), 20, level.state_bytes); })
                ->MinTime(0.05);
}

} // namespace

int main(int argc, char** argv) {
    add<1>();
    add<4>();
    add<8>();
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
}
