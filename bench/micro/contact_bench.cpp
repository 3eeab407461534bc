// Contact at the density of a nest: rods of 20 elements, 31 times as long as thick, at random places and directions,
// 138 to a cube of one length. Candidates by the grids and by looking at all pairs; then all that contacts cost a step
// while the list lasts. Then candidates and contacts in beds of other shapes (tests/support/beds.hpp).
//   names: candidates/<grids or all_pairs>/N<rods>[/threads<T>],  contacts/N<rods>/threads<T>,  bed/<name>/N<rods>,
//          bed_contacts/<name>/N<rods>
#include "contact/contacts.hpp"
#include "skein/core/index.hpp"
#include "support/beds.hpp"
#include "support/exposed_bodies.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <random>

namespace {

using namespace skein;

constexpr int elements = 20;
constexpr double diameter = 1.0 / 31;

/// Along a space-filling order, as a run has them: the box in slices, to and fro.
test::BodiesByHand nest(int rods) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform;
    std::normal_distribution<double> normal;
    const double side = std::cbrt(rods / 138.0);
    const int cells = std::max(1, static_cast<int>(4 * side));
    std::vector<std::pair<std::size_t, Vec3d>> places;
    for (int r = 0; r < rods; ++r) {
        const Vec3d x{side * uniform(random), side * uniform(random), side * uniform(random)};
        std::size_t at[3] = {};
        const double shares[3] = {x.z / side, x.y / side, x.x / side};
        for (int i = 0; i < 3; ++i) {
            at[i] = static_cast<std::size_t>(shares[i] * cells);
            if (i > 0 && at[i - 1] % 2) at[i] = static_cast<std::size_t>(cells) - 1 - at[i];
        }
        places.emplace_back((at[0] * static_cast<std::size_t>(cells) + at[1]) * static_cast<std::size_t>(cells) + at[2],
                            x);
    }
    std::stable_sort(places.begin(), places.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    test::BodiesByHand bodies;
    for (int r = 0; r < rods; ++r) {
        const Vec3d along{normal(random), normal(random), normal(random)};
        std::vector<Vec3d> nodes;
        for (int k = 0; k <= elements; ++k)
            nodes.push_back(nth(places, r).second + ((k - 0.5 * elements) / elements / norm(along)) * along);
        bodies.add(nodes, 0.5 * diameter);
    }
    return bodies;
}

/// Time of an iteration over a number of things.
benchmark::Counter per(double count) {
    return {count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert};
}

void candidates(benchmark::State& state, int rods, int thread_count, bool exhaustively) {
    const Threads threads(thread_count);
    const test::BodiesByHand bodies = nest(rods);
    const Exposure c = bodies.exposure();
    BroadPhase search(threads);
    Candidates found;
    const double skin = 0.25 * diameter;
    for (auto _ : state) {
        if (exhaustively) BroadPhase::build_exhaustively(c, bodies.rules, skin, found);
        else search.build(c, bodies.rules, skin, found);
        benchmark::DoNotOptimize(found.partner.data());
    }
    const double count = static_cast<double>(rods) * elements;
    state.counters["per element"] = per(count);
    state.counters["pairs per element"] = static_cast<double>(found.count()) / count;
}

/// Closest points, forces with friction that remembers, loads gathered by rod; nothing moves, so the list stays.
template <class Bodies> void push(benchmark::State& state, const Bodies& bodies, int rods, int thread_count) {
    const Threads threads(thread_count);
    Exposure c = bodies.exposure();
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    for (ExposedMotion& m : c.motion) m.velocity = {normal(random), normal(random), normal(random)};
    Contacts all(bodies.scene(ContactLaw{.normal = ContactNormal::hertz,
                                         .stiffness = 1e3,
                                         .damping = 1,
                                         .friction = ContactFriction::memory,
                                         .static_friction = 0.4,
                                         .kinetic_friction = 0.4}),
                 threads);
    SlotLoads loads;
    all.evaluate(c, 0, 1e-6, loads);
    for (auto _ : state) {
        all.evaluate(c, 0, 1e-6, loads);
        benchmark::DoNotOptimize(loads.load.data());
    }
    const ContactFigures figures = all.figures();
    state.counters["per candidate"] = per(static_cast<double>(figures.candidates));
    state.counters["per contact"] = per(static_cast<double>(figures.active));
    state.counters["per rod"] = per(rods);
    state.counters["contacts per rod"] = 2 * static_cast<double>(figures.active) / rods;
    state.counters["searched per contact, s"] = figures.search_s / static_cast<double>(figures.active);
}

void contacts(benchmark::State& state, int rods, int thread_count) { push(state, nest(rods), rods, thread_count); }

void bed_contacts(benchmark::State& state, std::string_view name, int rods) {
    push(state, test::Bed(name, rods), rods, 1);
}

void bed(benchmark::State& state, std::string_view name, int rods) {
    const Threads threads(1);
    const test::Bed rods_of_bed(name, rods);
    const Exposure c = rods_of_bed.exposure();
    BroadPhase search(threads);
    Candidates found;
    for (auto _ : state) {
        search.build(c, rods_of_bed.rules(), 0.5, found);
        benchmark::DoNotOptimize(found.partner.data());
    }
    const auto kept = static_cast<double>(found.count());
    state.counters["per candidate"] = per(kept);
    state.counters["per element"] = per(static_cast<double>(rods) * test::Bed::elements);
    state.counters["tested per candidate"] = static_cast<double>(search.tested()) / kept;
    state.counters["pairs per element"] = kept / rods / test::Bed::elements;
}

} // namespace

int main(int argc, char** argv) {
    for (const int rods : {1000, 10000, 100000})
        for (const int threads : {1, 2})
            benchmark::RegisterBenchmark(fmt::format("candidates/grids/N{}/threads{}", rods, threads).c_str(),
                                         candidates, rods, threads, false)
                ->UseRealTime();
    for (const int rods : {250, 500, 1000, 2000})
        for (const bool all : {false, true})
            benchmark::RegisterBenchmark(fmt::format("candidates/{}/N{}", all ? "all_pairs" : "grids", rods).c_str(),
                                         candidates, rods, 1, all);
    for (const int rods : {100, 1000, 10000, 100000})
        for (const int threads : {1, 2})
            benchmark::RegisterBenchmark(fmt::format("contacts/N{}/threads{}", rods, threads).c_str(), contacts, rods,
                                         threads)
                ->UseRealTime();
    for (const std::string_view name : test::bed_names)
        benchmark::RegisterBenchmark(fmt::format("bed/{}/N2000", name).c_str(), bed, name, 2000);
    for (const std::string_view name : {"nest", "layer", "brush", "mixed"})
        benchmark::RegisterBenchmark(fmt::format("bed_contacts/{}/N100000", name).c_str(), bed_contacts, name, 100000);
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
