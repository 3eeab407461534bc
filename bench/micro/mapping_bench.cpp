// What rods cost that do not fill tiles: lone rods of 1000, 200 and 50 elements, and rods of 5 to 100 elements in one
// scene, over the same work on equal rods across tiles: 16 rods of 50 in L2 beside lone rods, as many rods of 52 beside
// the scenes. Cilia. And a lone rod of 50 that lies on a plane or is dragged through a fluid, over the same rod under
// gravity alone. Medians of interleaved turns. The bits are those of one lane across, which is checked first.
#include "loads/gravity.hpp"
#include "loads/plane_friction.hpp"
#include "loads/slender_body_drag.hpp"
#include "measure.hpp"
#include "support/scenes_for_tests.hpp"

#include <CLI/CLI.hpp>
#include <fmt/os.h>

#include <algorithm>
#include <optional>

namespace {

using namespace skein;
using test::Stage;

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

/// A rod under gravity, and one load more.
SceneSpec lone_rod(std::optional<Load> load) {
    SceneSpec scene;
    scene.rods = {test::simple_rod(50)};
    scene.time = {.duration = 1, .dt = 1e-5};
    scene.loads = {{.load = Gravity{}}};
    if (load) scene.loads.push_back({.load = std::move(*load)});
    return scene;
}

Load rough_plane() {
    PlaneFriction plane{.point = {0, 0, -0.02}, .stiffness = 1, .damping = 1e-6, .tolerance = 1};
    plane.kinetic_forward = plane.static_forward = 0.1;
    plane.kinetic_backward = plane.static_backward = 0.15;
    plane.kinetic_sideways = plane.static_sideways = 0.2;
    return plane;
}

struct Row {
    std::string name;
    double bar;
    SceneSpec scene, equal;
    std::unique_ptr<Stage> stage{}, block{};
    std::vector<double> ns{}, block_ns{};
};

/// ns per element-step of about 50 ms of stepping.
double timed(Stage& stage, std::int64_t per_visit) {
    const double elements = static_cast<double>(stage.plan.elements);
    const auto steps = std::max<std::int64_t>(64, static_cast<std::int64_t>(0.05 / (elements * 13e-9)) / 64 * 64);
    const double start = bench::core_seconds();
    stage.advance(stage.clock.done() + steps, per_visit);
    return (bench::core_seconds() - start) * 1e9 / (elements * static_cast<double>(steps));
}

std::uint64_t digest_after(const SceneSpec& scene, int lanes, std::int64_t steps) {
    Stage stage(scene, lanes);
    stage.advance(steps);
    return stage.rods->digest();
}

} // namespace

int main(int argc, char** argv) {
    long turns = 15;
    std::string csv;
    CLI::App app{"Lone rods and rods of unlike lengths over equal rods"};
    app.add_option("--turns", turns, "of which the table shows the median")->check(CLI::PositiveNumber);
    app.add_option("--csv", csv, "file for the table");
    CLI11_PARSE(app, argc, argv);

    std::optional<fmt::ostream> file;
    if (!csv.empty()) {
        file.emplace(fmt::output_file(csv));
        file->print("scene,steps_per_visit,ns,equal_rods_ns,ratio,bar,digest_after_64_steps\n");
    }
    fmt::print("{}; ns per element-step\n\n{:<38}{:>12}{:>8}{:>12}{:>8}{:>7}  {}\n", bench::processor(), "",
               "steps/visit", "ns", "equal", "ratio", "bar", "digest after 64 steps");
    for (const std::int64_t per_visit : {std::int64_t{1}, std::int64_t{Clock::largest_batch}}) {
        std::vector<Row> rows;
        for (const auto& [n, bar] : {std::pair{1000L, 1.4}, std::pair{200L, 1.5}, std::pair{50L, 1.8}})
            rows.push_back({fmt::format("a lone rod of {}", n), bar, cilia(1, n), cilia(16, 50)});
        for (const long count : {1L, 2L, 4L, 8L, 20L})
            rows.push_back(
                {fmt::format("5 to 100 elements, {} of each", count), 1.3, mixed(count), cilia(96 * count, 52)});
        rows.push_back({"on an anisotropic_plane, over gravity", 2.5, lone_rod(rough_plane()), lone_rod({})});
        rows.push_back(
            {"with slender_body_drag, over gravity", 2.5, lone_rod(SlenderBodyDrag{.viscosity = 0.02}), lone_rod({})});
        for (Row& row : rows) {
            row.stage = std::make_unique<Stage>(row.scene);
            row.block = std::make_unique<Stage>(row.equal);
        }
        for (long turn = 0; turn <= turns; ++turn)
            for (Row& row : rows) {
                const double ns = timed(*row.stage, per_visit), block_ns = timed(*row.block, per_visit);
                if (turn > 0) { // the first one warms up
                    row.ns.push_back(ns);
                    row.block_ns.push_back(block_ns);
                }
            }
        for (const Row& row : rows) {
            const std::uint64_t digest = digest_after(row.scene, 8, 64);
            if (digest != digest_after(row.scene, 1, 64)) {
                fmt::print("{}: the bits differ from those of one lane\n", row.name);
                return 1;
            }
            const double ns = bench::median(row.ns), block_ns = bench::median(row.block_ns);
            fmt::print("{:<38}{:>12}{:>8.2f}{:>12.2f}{:>8.2f}{:>7.1f}  {:016x}\n", row.name, per_visit, ns, block_ns,
                       ns / block_ns, row.bar, digest);
            if (file)
                file->print("\"{}\",{},{:.4g},{:.4g},{:.4g},{},{:016x}\n", row.name, per_visit, ns, block_ns,
                            ns / block_ns, row.bar, digest);
        }
    }
    return 0;
}
