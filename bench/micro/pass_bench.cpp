// Every pass of the step and the step itself, and the rotation of frames alone, at W = 1, 2, 4, 8, with rods of 20, 50
// and 100 elements whose state lies in L1, L2, L3 or DRAM; each beside the multiply-add peak at its width and the
// bandwidth of an update in place of as many bytes, from the same run. Medians of five repetitions of processor time;
// flop by the cost lines of the headers.
//   bench_passes [--csv FILE] [--benchmark_filter=REGEX]
//   names: <pass>/W<width>/n<elements>/<level>, step/<rods>/visit<steps>/...; rotation/W<width>/<level>, peak/...,
//   stream-.../...
// Without a filter: everything at W = 8, and the other widths in L2. With =. all.
#include "implicit/make_bed_pass.hpp"
#include "implicit/make_implicit_pass.hpp"
#include "kernels/make_rods_at.hpp"
#include "loads/load_passes.hpp"
#include "mechanics/drift.hpp"
#include "mechanics/kick.hpp"
#include "micro/roof_table.hpp"
#include "micro/roofs.hpp"
#include "micro/working_set.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"

#include <cstring>

namespace {

using namespace skein;
using namespace skein::bench;

constexpr double dt = 1e-5;

/// Doubles of a slot that a pass reads and writes, and flop per element by the header's cost line.
struct Cost {
    double flop, read, written;
};

SceneSpec rods(long elements, bool circular) {
    SceneSpec scene = test::cilia_scene(8, elements);
    if (!circular) scene.rods[0].section = {.kind = SectionKind::elliptic, .radius = 0.15, .radius_2 = 0.1};
    return scene;
}

SceneSpec uniform_rods(long elements) {
    SceneSpec scene = test::cilia_scene(8, elements, EndKind::free);
    scene.rods[0].magnetisation = {};
    scene.loads.clear();
    scene.damping.clear();
    return scene;
}

/// The set that the row before was run on, where it is the same: large ones take longer to make than to measure.
template <int W> WorkingSet<W>& working_set(const RodGroup& group, double bytes) {
    static std::unique_ptr<WorkingSet<W>> kept;
    static double kept_bytes = 0;
    static const RodGroup* kept_group = nullptr;
    if (&group != kept_group || bytes != kept_bytes) {
        kept.reset();
        kept = std::make_unique<WorkingSet<W>>(group, bytes);
        kept_group = &group;
        kept_bytes = bytes;
    }
    kept->reset();
    return *kept;
}

/// Groups of rods live as long as the program.
const RodGroup& group_of(const SceneSpec& scene) {
    static std::map<std::string, std::vector<RodGroup>> groups;
    auto& found = groups[scene_json(scene, false)];
    if (found.empty()) found = make_groups(scene);
    return found[0];
}

template <int W> void run_program(benchmark::State& state, const RodGroup& group, TilePasses<W> program, Cost cost,
                                  double bytes, int per_visit) {
    WorkingSet<W>& set = working_set<W>(group, bytes);
    for (const RodTile<W>& tile : set.tiles())
        for (const auto& pass : program) pass->bind(tile);
    Clock clock(dt, 1);
    const auto steps = clock.next(1 + per_visit);
    for (const auto& pass : program) pass->prepare(steps);
    for (auto _ : state) {
        for (const RodTile<W>& tile : set.tiles())
            for (const Step& step : steps)
                for (const auto& pass : program) pass->run(tile, set.load(), step);
        benchmark::ClobberMemory();
    }
    const double slots_per_element = static_cast<double>(group.slots()) / group.elements();
    set_cost(state, set.elements() * per_visit, cost.flop,
             sizeof(double) * (cost.read + cost.written) * slots_per_element / per_visit, set.state_bytes());
}

/// Frames and rates alone, as a kernel that turns frames and does nothing else would store them.
template <int W> struct Turning {
    Quaternion<Pack<W>> director;
    Vec3<Pack<W>> spin;
};

/// Q <- R(h w) Q in place: no positions, no top's precession.
template <int W> [[gnu::noinline]] void rotate(Turning<W>* record, std::size_t count, double length) {
    constexpr std::size_t ahead =
        1024 / sizeof(Turning<W>) + 8; // what the hardware asks for by itself comes late from memory
    const Pack<W> half(0.5 * length);
    for (std::size_t k = 0; k < count; ++k) {
        for (std::size_t line = 0; line < sizeof(Turning<W>); line += 64)
            __builtin_prefetch(reinterpret_cast<const char*>(&record[k + ahead]) + line, 1, 2);
        record[k].director = rotation_by_twice<W>(half * record[k].spin) * record[k].director;
    }
}

template <int W> void run_rotation(benchmark::State& state, double bytes) {
    const auto count = static_cast<std::size_t>(bytes / sizeof(Turning<W>));
    AlignedVector<Turning<W>> records(count, {broadcast<W>(no_turn), broadcast<W>(Vec3d{30, 20, 10})});
    for (auto _ : state) {
        rotate<W>(records.data(), count, 1e-3);
        benchmark::ClobberMemory();
    }
    set_cost(state, static_cast<double>(count * W), 59, 8 * (7 + 4), static_cast<double>(count * sizeof(Turning<W>)));
}

template <class Function> void add(const std::string& name, Function run) {
    benchmark::RegisterBenchmark(name.c_str(), run)->MinTime(0.01)->Repetitions(5);
}

template <int W, class Make>
void add_pass(const char* name, long n, const Level& level, Cost cost, const SceneSpec& scene, Make make) {
    const RodGroup& group = group_of(scene);
    add(fmt::format("{}/W{}/n{}/{}", name, W, n, level.name), [=, &group](benchmark::State& state) {
        TilePasses<W> program;
        program.emplace_back(make(group));
        run_program<W>(state, group, std::move(program), cost, level.state_bytes, 1);
    });
}

template <int W>
void add_step(const char* name, long n, const Level& level, Cost cost, const SceneSpec& scene, int per_visit) {
    const RodGroup& group = group_of(scene);
    const GroupPlan plan = make_plan(scene, {&group, 1}, {1, 1, 1, W}).groups[0];
    add(fmt::format("step/{}/visit{}/W{}/n{}/{}", name, per_visit, W, n, level.name),
        [=, &group](benchmark::State& state) {
            const Surroundings around;
            const PassParts<W> parts{.plan = plan,
                                     .group = group,
                                     .scheme = scheme_of(Integrator::verlet),
                                     .dt = dt,
                                     .around = around,
                                     .walls = nullptr,
                                     .audit = nullptr,
                                     .moving = nullptr};
            run_program<W>(state, group, make_program<W>(plan.program, PassMaker<W>(parts)).passes, cost,
                           level.state_bytes, per_visit);
        });
}

template <int W> void add_width() {
    const auto kick = []<KickKind Kind>(std::integral_constant<KickKind, Kind>, std::vector<Damping> damping) {
        return [damping](const RodGroup& group) {
            return new KickPass<Kind, W>({KickConstants(group, damping_rates(group, damping), dt)});
        };
    };
    using Undamped = std::integral_constant<KickKind, KickKind::undamped>;
    using Constant = std::integral_constant<KickKind, KickKind::constant_rates>;
    using Stretched = std::integral_constant<KickKind, KickKind::stretched_rates>;

    for (const Level& level : levels) {
        add(fmt::format("rotation/W{}/{}", W, level.name),
            [&level](benchmark::State& state) { run_rotation<W>(state, level.state_bytes); });
        for (const long n : {20L, 50L, 100L}) {
            if (&level == &levels[0] && !fits_in_l1<W>(n)) continue;
            const SceneSpec circular = rods(n, true), elliptic = rods(n, false), uniform = uniform_rods(n);
            add_pass<W>("drift-circular", n, level, {112, 13, 9}, circular,
                        [](const RodGroup&) { return new DriftPass<CircularGyration, W>; });
            add_pass<W>("drift-elliptic", n, level, {189, 13, 10}, elliptic,
                        [](const RodGroup&) { return new DriftPass<EllipticGyration<1>, W>; });
            add_pass<W>("elastic", n, level, {211, 7, 0}, circular, [](const RodGroup&) {
                return new ElasticPass<IncompressibleLaw, W>(Ends{.start_wall = true});
            });
            add_pass<W>("magnetic-field", n, level, {45, 4, 0}, circular, [](const RodGroup& group) {
                return new LoadPass<MagneticField, W>({.constant = {0, 8e-4, 0}, .rotating = 0.08, .period = 72},
                                                      group);
            });
            add_pass<W>("kick-undamped", n, level, {12, 6, 6}, circular, kick(Undamped{}, {}));
            add_pass<W>("kick-constant", n, level, {18, 6, 6}, circular,
                        kick(Constant{}, {{.kind = DampingKind::uniform, .rate = 0.5}}));
            add_pass<W>("kick-stretched", n, level, {41, 6, 6}, circular,
                        kick(Stretched{}, {{.kind = DampingKind::legacy, .rate = 0.5}}));
            for (const int per_visit : {1, Clock::largest_batch}) {
                add_step<W>("uniform", n, level, {112 + 211 + 12, 13, 13}, uniform, per_visit);
                add_step<W>("cilia", n, level, {112 + 211 + 45 + 41, 13, 13}, circular, per_visit);
            }
        }
    }
}

void add_roofs() {
    add("peak/W8", run_peak<8>);
    add("peak/W4", run_peak<4>);
    add("peak/W2", run_peak<2>);
    add("peak/W1", run_peak<1>);
    for (const Level& level : levels) {
        add(fmt::format("stream-update/W8/{}", level.name),
            [&level](benchmark::State& state) { run_update<8, 8>(state, level.state_bytes); });
        add(fmt::format("stream-4-of-7/W8/{}", level.name),
            [&level](benchmark::State& state) { run_update<7, 4>(state, level.state_bytes); });
        add(fmt::format("stream-triad/W8/{}", level.name),
            [&level](benchmark::State& state) { run_triad(state, level.state_bytes); });
    }
}

/// Takes "--csv FILE" out of the command line.
std::string take_csv(int& argc, char** argv) {
    for (int i = 1; i + 1 < argc; ++i)
        if (std::strcmp(argv[i], "--csv") == 0) {
            const std::string file = argv[i + 1];
            std::copy(argv + i + 2, argv + argc, argv + i);
            argc -= 2;
            return file;
        }
    return {};
}

} // namespace

int main(int argc, char** argv) {
    const std::string csv = take_csv(argc, argv);
    add_roofs();
    add_width<8>();
    add_width<4>();
    add_width<2>();
    add_width<1>();
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    const std::string filter = benchmark::GetBenchmarkFilter();
    RoofTable table(csv);
    benchmark::RunSpecifiedBenchmarks(&table, filter.empty() ? "peak|stream|rotation|W8|L2" : filter);
    return 0;
}
