// What each feature adds to the step of uniform, free, undamped rods: gravity, a damper, a clamp, a magnetic couple, a
// muscle wave, all of them, and all of them in the scene but on other rods; eight lanes, one thread, state in L2.
//   bench_features [--csv FILE] [--repeats 25]
// Every repeat times each row once, in turn; a row's cost is the median over the repeats of its processor time over
// that of the base in the same repeat. The bars are 10 % for a feature, 20 % for all, 2 % for what is in the scene but
// not on these rods.
#include "loads/gravity.hpp"
#include "loads/magnetic_field.hpp"
#include "loads/muscle_wave.hpp"
#include "measure.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "support/scenes_for_tests.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/os.h>

#include <algorithm>
#include <memory>

namespace {

using namespace skein;
using bench::core_seconds;
using bench::median;
using test::Stage;

constexpr double state_bytes = 384e3; // in L2
constexpr double bar_one = 0.10, bar_all = 0.20, bar_off = 0.02;

SceneSpec base(long elements) {
    const long tiles =
        static_cast<long>(state_bytes / static_cast<double>((elements + 1) * static_cast<long>(sizeof(Slot<8>))));
    SceneSpec scene;
    scene.time.duration = 1e6;
    RodSpec rod = test::simple_rod(elements);
    rod.placement = {.kind = PlacementKind::line, .counts = {8 * tiles}, .spacing = {1}};
    rod.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 100};
    scene.rods = {rod};
    return scene;
}

const std::vector<LoadSpec> loads = {{.load = Gravity{}},
                                     {.load = MagneticField{.rotating = 1e-3, .period = 1}},
                                     {.load = MuscleWave{.amplitude = 1e-6, .period = 1, .wavelength = 1}}};
const DampingSpec damper{.damping = {.kind = DampingKind::uniform, .rate = 0.5}};

struct Feature {
    const char* name;
    double bar; ///< of the cost; 0: none
    void (*add)(SceneSpec&);
};
const Feature features[] = {
    {"base", 0, [](SceneSpec&) {}},
    {"gravity", bar_one, [](SceneSpec& s) { s.loads = {loads[0]}; }},
    {"damper", bar_one, [](SceneSpec& s) { s.damping = {damper}; }},
    {"clamp", bar_one, [](SceneSpec& s) { s.rods[0].start = EndKind::clamped; }},
    {"magnetic couple", bar_one, [](SceneSpec& s) { s.loads = {loads[1]}; }},
    {"muscle wave", bar_one, [](SceneSpec& s) { s.loads = {loads[2]}; }},
    {"all", bar_all,
     [](SceneSpec& s) {
         s.loads = loads;
         s.damping = {damper};
         s.rods[0].start = EndKind::clamped;
     }},
    {"all, on other rods", bar_off,
     [](SceneSpec& s) { // eight rods of two elements
         RodSpec other = s.rods[0];
         other.name = "other";
         other.shape.elements = 2;
         other.shape.length = 2 * other.shape.length / static_cast<double>(s.rods[0].shape.elements);
         other.start = EndKind::clamped;
         other.placement = {.kind = PlacementKind::line, .origin = {0, 3, 0}, .counts = {8}, .spacing = {1}};
         s.rods.push_back(other);
         s.loads = loads;
         s.damping = {damper};
         for (LoadSpec& load : s.loads) load.rods = {"other"};
         s.damping[0].rods = {"other"};
     }},
};

struct Row {
    const Feature* feature;
    std::unique_ptr<Stage> stage;
    std::vector<double> seconds{};
};

} // namespace

int main(int argc, char** argv) {
    long repeats = 25;
    std::string csv;
    CLI::App app{"What each feature adds to a step"};
    app.add_option("--repeats", repeats, "repeats, of which the table shows the median")->check(CLI::PositiveNumber);
    app.add_option("--csv", csv, "file for the table");
    CLI11_PARSE(app, argc, argv);

    std::optional<fmt::ostream> file;
    if (!csv.empty()) {
        file.emplace(fmt::output_file(csv));
        file->print("elements,steps_per_visit,feature,ns,over_base,bar,steps,digest\n");
    }
    fmt::print("{}; ns per element-step, state in L2\n\n{:<4}{:>12}  {:<20}{:>8}{:>11}{:>8}  {}\n", bench::processor(),
               "n", "steps/visit", "feature", "ns", "over base", "bar", "digest");
    for (const long n : {20L, 50L})
        for (const std::int64_t per_visit : {std::int64_t{1}, std::int64_t{Clock::largest_batch}}) {
            std::vector<Row> rows;
            for (const Feature& feature : features) {
                SceneSpec scene = base(n);
                scene.time.dt = 0.3 * make_plan(scene, make_groups(scene), {}).limit; // the same for all
                feature.add(scene);
                rows.push_back({&feature, std::make_unique<Stage>(scene)});
            }
            constexpr std::int64_t steps = 512; // 20 ms
            for (long repeat = 0; repeat <= repeats; ++repeat)
                for (Row& row : rows) {
                    const double start = core_seconds();
                    row.stage->advance((repeat + 1) * steps, per_visit);
                    if (repeat > 0) row.seconds.push_back(core_seconds() - start); // the first one warms up
                }
            for (const Row& row : rows) {
                std::vector<double> over;
                for (std::size_t i = 0; i < row.seconds.size(); ++i)
                    over.push_back(row.seconds[i] / static_cast<double>(row.stage->plan.elements) /
                                       (rows[0].seconds[i] / static_cast<double>(rows[0].stage->plan.elements)) -
                                   1);
                const double ns = 1e9 * median(row.seconds) / static_cast<double>(row.stage->plan.elements * steps),
                             cost = median(over), bar = row.feature->bar;
                const std::int64_t done = row.stage->clock.done();
                fmt::print("{:<4}{:>12}  {:<20}{:>8.2f}{:>11}{:>8}  {:016x}\n", n, per_visit, row.feature->name, ns,
                           bar == 0 ? "-" : fmt::format("{:+.1f} %", 100 * cost),
                           bar == 0 ? "-" : fmt::format("{:.0f} %", 100 * bar), row.stage->rods->digest());
                if (file)
                    file->print("{},{},\"{}\",{:.4g},{:.4g},{},{},{:016x}\n", n, per_visit, row.feature->name, ns, cost,
                                bar, done, row.stage->rods->digest());
            }
        }
    return 0;
}
