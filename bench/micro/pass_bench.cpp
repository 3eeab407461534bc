// Each pass of the step alone, at W = 8 and 1, over tiles that stay in L2: ns per element and flop rate by the cost line of the
// pass's header, next to the fused multiply-add peak of the same core in the same run.
//   names: pass/<pass>/W<width>/n<elements>
#include "core/aligned.hpp"
#include "loads/load_pass.hpp"
#include "rod/drift.hpp"
#include "rod/elastic.hpp"
#include "support/scenes_for_tests.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

namespace {

using namespace skein;

constexpr double dt = 1e-5;

RodSpec bent_rod(long elements, bool circular) {
    SceneSpec scene = test::cilia_scene(16, elements);
    RodSpec rod = scene.rods[0];
    if (!circular) rod.section = {.kind = SectionKind::elliptic, .radius = 0.15, .radius_2 = 0.1};
    rod.shape.start_curvature = Vec3d{0.4, -0.3, 0.5};
    rod.shape.angular_velocity = {0.3, 0.2, 0.1};
    return rod;
}

/// Two tiles and their loads.
template <int W> struct Tiles {
    RodGroup group;
    AlignedVector<Slot<W>> slots;
    AlignedVector<SlotLoad<W>> load;
    std::vector<RodTile<W>> tiles;

    Tiles(long elements, bool circular)
        : group(bent_rod(elements, circular), 0, 0, ""), slots(2 * static_cast<std::size_t>(group.slots())), load(static_cast<std::size_t>(group.slots())) {
        std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
        group.start_state(0, state);
        for (std::size_t t = 0; t < 2; ++t) {
            RodTile<W> tile{slots.data() + t * state.size(), group.element.data(), group.voronoi.data(), &group, group.elements(), t, {}, W};
            for (int i = 0; i < W; ++i) {
                tile.index[i] = static_cast<std::int64_t>(t) * W + i;
                for (std::size_t k = 0; k < state.size(); ++k) {
                    set_lane(tile.slot[k].position, i, lane(state[k].position, 0));
                    set_lane(tile.slot[k].velocity, i, lane(state[k].velocity, 0));
                    set_lane(tile.slot[k].director, i, lane(state[k].director, 0));
                    set_lane(tile.slot[k].spin, i, lane(state[k].spin, 0));
                }
            }
            tiles.push_back(tile);
        }
        const ElasticPass<IncompressibleLaw, W> elastic(Ends{.start_wall = true});
        elastic.run(tiles[0], load.data(), {}); // loads for passes that only read them
    }
};

/// Makes the pass for a group and runs it; `flop` per element is the cost line of its header.
template <int W, class Make> void run_pass(benchmark::State& state, long elements, bool circular, double flop, Make make) {
    Tiles<W> tiles(elements, circular);
    const std::unique_ptr<TilePass<W>> pass = make(tiles.group);
    for (const RodTile<W>& tile : tiles.tiles) pass->bind(tile);
    const Step step{.index = 1, .dt = dt, .drift = dt, .time = 0.5, .slot = 0};
    pass->prepare({&step, 1});
    for (auto _ : state) {
        for (const RodTile<W>& tile : tiles.tiles) pass->run(tile, tiles.load.data(), step);
        benchmark::ClobberMemory();
    }
    const double work = static_cast<double>(tiles.tiles.size() * W) * static_cast<double>(elements);
    state.counters["per element"] = benchmark::Counter(work, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    state.counters["flop/s"] = benchmark::Counter(flop * work, benchmark::Counter::kIsIterationInvariantRate);
}

/// Twelve independent chains of fused multiply-adds in registers: what the core can do at this width.
template <int W> void run_peak(benchmark::State& state) {
    using P = Pack<W>;
    constexpr int chains = 12, links = 100;
    P x[chains];
    for (int i = 0; i < chains; ++i) x[i] = P(1.0 + 0.01 * i);
    const P a(0.999), b(0.001);
    for (auto _ : state) {
        for (int link = 0; link < links; ++link)
            for (int i = 0; i < chains; ++i) x[i] = fma(x[i], a, b);
        benchmark::DoNotOptimize(x);
    }
    const double work = 1.0 * chains * links * W; // of one multiply-add in one lane each
    state.counters["per element"] = benchmark::Counter(work, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    state.counters["flop/s"] = benchmark::Counter(2 * work, benchmark::Counter::kIsIterationInvariantRate);
}

template <int W> void register_width() {
    const auto add = [](const char* name, long elements, bool circular, double flop, auto make) {
        benchmark::RegisterBenchmark(fmt::format("pass/{}/W{}/n{}", name, W, elements).c_str(), [=](benchmark::State& state) {
            run_pass<W>(state, elements, circular, flop, [&](const RodGroup& group) { return std::unique_ptr<TilePass<W>>(make(group)); });
        });
    };
    const auto kick = []<KickKind Kind>(std::integral_constant<KickKind, Kind>, std::vector<Damping> damping) {
        return [damping](const RodGroup& group) { return new KickPass<Kind, W>({KickConstants(group, damping_rates(group, damping), dt)}); };
    };
    using Undamped = std::integral_constant<KickKind, KickKind::undamped>;
    using Constant = std::integral_constant<KickKind, KickKind::constant_rates>;
    using Stretched = std::integral_constant<KickKind, KickKind::stretched_rates>;

    benchmark::RegisterBenchmark(fmt::format("peak/fma/W{}", W).c_str(), run_peak<W>);
    for (const long n : {10L, 25L, 50L, 100L}) {
        add("drift_circular", n, true, 112, [](const RodGroup&) { return new DriftPass<CircularTop, W>; });
        add("drift_elliptic", n, false, 189, [](const RodGroup&) { return new DriftPass<EllipticTop<1>, W>; });
        add("elastic", n, true, 211, [](const RodGroup&) { return new ElasticPass<IncompressibleLaw, W>(Ends{.start_wall = true}); });
        add("magnetic_field", n, true, 24, [](const RodGroup& group) {
            return new LoadPass<MagneticField, W>({.constant = {0, 8e-4, 0}, .rotating = 0.08, .period = 72}, group);
        });
        add("kick_undamped", n, true, 12, kick(Undamped{}, {}));
        add("kick_constant", n, true, 18, kick(Constant{}, {{.kind = DampingKind::uniform, .rate = 0.5}}));
        add("kick_stretched", n, true, 41, kick(Stretched{}, {{.kind = DampingKind::legacy, .rate = 0.5}}));
        add("kick_stretched_elliptic", n, false, 53, kick(Stretched{}, {{.kind = DampingKind::legacy, .rate = 0.5}}));
    }
}

} // namespace

int main(int argc, char** argv) {
    register_width<8>();
    register_width<1>();
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
