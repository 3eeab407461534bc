// Time of an equilibrium: one cantilever under a force on its tip of 1 EI/L^2, by elements and stretch law, with its
// system and without. The least and the median of many.
#include "equilibrium/newton.hpp"
#include "loads/end_force.hpp"
#include "measure.hpp"
#include "support/scenes_for_tests.hpp"

#include <CLI/CLI.hpp>
#include <fmt/os.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace {

using namespace skein;

SceneSpec cantilever(long n, Law law) {
    constexpr double slenderness = 500, modulus = 1e9;
    SceneSpec scene;
    RodSpec rod = test::clamped_unit_rod(n, 1 / slenderness);
    rod.material.youngs_modulus = modulus;
    rod.material.law = law;
    const double bending = modulus * 0.25 * std::numbers::pi / std::pow(slenderness, 4);
    scene.rods = {rod};
    scene.loads = {{.load = EndForce{.end = {bending, 0, 0}}}};
    scene.time.duration = 1;
    return scene;
}

struct Times {
    std::vector<double> all, solution; ///< ms: with the system, and without
    std::size_t corrections = 0;
};

Times timed(long n, Law law, int turns) {
    const SceneSpec scene = cantilever(n, law);
    const std::vector<RodGroup> groups = make_groups(scene);
    const Plan plan = make_plan(scene, groups, {});
    const std::vector<LocalRod> rods = test::all_rods(groups);
    Times times;
    for (int i = 0; i < turns; ++i) {
        const double began = bench::core_seconds();
        StaticSystem system(groups, rods, make_static_rods(plan, groups, rods, nullptr));
        StaticState state = start_of(system, groups, rods);
        const double made = bench::core_seconds();
        const Equilibrium found = NewtonSolver(system, {}).find(state, 1);
        const double done = bench::core_seconds();
        if (!found.found) throw std::runtime_error(found.reason);
        times.all.push_back(1e3 * (done - began));
        times.solution.push_back(1e3 * (done - made));
        times.corrections = found.last.passes.size();
    }
    return times;
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("Time of an equilibrium of one rod");
    std::vector<long> elements{40, 1000};
    int turns = 50;
    app.add_option("--elements", elements, "elements of the rod");
    app.add_option("--turns", turns, "solutions of each")->check(CLI::PositiveNumber);
    CLI11_PARSE(app, argc, argv);
    fmt::print("{}\n{:>9} {:>15} {:>12} {:>12} {:>12} {:>12}\n", bench::processor(), "elements", "law", "corrections",
               "least ms", "median ms", "with system");
    for (const long n : elements)
        for (const auto& [law, name] : {std::pair{Law::incompressible, "incompressible"}, {Law::linear, "linear"}}) {
            const Times times = timed(n, law, turns);
            fmt::print("{:>9} {:>15} {:>12} {:>12.3f} {:>12.3f} {:>12.3f}\n", n, name, times.corrections,
                       *std::min_element(times.solution.begin(), times.solution.end()), bench::median(times.solution),
                       bench::median(times.all));
        }
    return 0;
}
