// Error against work, over rod law, clamp, damping scheme, integrator, number of elements n and step.
//   bench_work_precision [--case NAME]... [--csv FILE]
//
// at rest, over n
//   timoshenko        thick rod under a tip force: tip against Timoshenko's line, over its deflection
//   magnetised        rod magnetised along its axis in a field across it, bond 1: tip against its boundary-value
//   problem, over its
//                     deflection
//   large_rotation    tip load 4 E I/L^2 in three dimensions: tip against its boundary-value problem, lengths
//   bend              the same on an arc of 45 degrees, 6 E I/L^2
//   axial_stretching  rod stretched by half: end against its integral, over the extension
//   catenary          hung by both ends: nine nodes against the quadrature, lengths
//   euler_buckling    critical load against its closed form, over itself
//   helical_buckling  27 turns: envelope at nineteen stations against the localised helix of an inextensible rod
// undamped, let go in a mode, over n: phase, rad
//   bending_mode_0, bending_mode_1     slender clamped rod after a quarter period of Timoshenko's frequencies
//   axial_wave, torsional_wave         standing waves, three quarters of a wave on the rod, after two periods and a
//   quarter
// undamped, free, over the step
//   free_rod          bent, twisted, spinning, 4 s: largest change of energy over the start's
//   butterfly         folded to a right angle, 40 s: the same
//   top               elliptic, free: directors against Jacobi's functions
// driven, over n
//   cilium            eight damped cilia in a row: tips at eight instants against each law's own finest runs, lengths
// one_percent         timoshenko again: work until the tip is within 1 % of the line for good
//
// Work counts the rods of the scene: one or two on one lane, or eight cilia on eight. Core time is that of steps alone,
// best of repeats up to 20 ms.
#include "scenes/work_precision/cases.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>

int main(int argc, char** argv) {
    using namespace skein::bench;
    std::vector<Case> cases;
    for (const auto& kind : {cases_at_rest(), cases_of_waves(), cases_of_energy(), driven_cases()})
        cases.insert(cases.end(), kind.begin(), kind.end());
    std::vector<std::string> names, chosen;
    for (const Case& c : cases) names.push_back(c.name);
    names.push_back("one_percent");

    std::string csv;
    CLI::App app{"Error against work over law, clamp, damping, integrator, n and dt"};
    app.add_option("--case", chosen, "cases to run; all where absent")->check(CLI::IsMember(names));
    app.add_option("--csv", csv, "file for the table");
    CLI11_PARSE(app, argc, argv);
    const auto wanted = [&](const std::string& name) {
        return chosen.empty() || std::find(chosen.begin(), chosen.end(), name) != chosen.end();
    };
    Table table(csv);
    for (const Case& c : cases)
        if (wanted(c.name)) climb(c, table);
    if (wanted("one_percent")) one_percent(table);
}
