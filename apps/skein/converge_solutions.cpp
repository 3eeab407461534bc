#include "converge_solutions.hpp"

#include "solving.hpp"

#include "io/files.hpp"
#include "simulation/machine.hpp"
#include "studies/modes_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <map>
#include <utility>

namespace skein {

namespace {

RunArguments run_arguments(const ConvergeArguments& arguments, const std::string& out) {
    RunArguments run;
    run.scene = arguments.scene;
    run.options.out = out;
    run.options.overwrite = arguments.overwrite;
    run.options.quiet = true;
    run.threads = arguments.threads;
    run.lanes = arguments.lanes;
    run.mapping = arguments.mapping;
    return run;
}

/// A number that is not of the time series; its range is its size.
Quantity quantity(const char* name, std::size_t number, const std::string& unit, double value) {
    return {fmt::format("{}_{}", name, number + 1), unit, 1, {0, value}, true};
}

std::vector<Quantity> frequencies_of(const ModesReport& report) {
    std::vector<Quantity> out;
    for (const PieceMode& one : report.modes) {
        if (one.mode.neutral) continue;
        const double frequency = one.mode.frequency();
        out.push_back(quantity("frequency", out.size(), "Hz", one.mode.eigenvalue < 0 ? -frequency : frequency));
    }
    return out;
}

/// An equilibrium, and modes about it where they are asked for.
StudySolution solve_at_rest(const Communicator& comm, const StudyRun& run, const ConvergeArguments& arguments,
                            const std::string& out, Friction friction) {
    SolvedScene solved =
        solved_scene(comm, run_arguments(arguments, out), {}, friction, [&](SceneSpec& scene) { scene = run.scene; });
    StaticScene at_rest(solved.simulation->world());
    StudySolution solution;
    double seconds = find_and_tell(solved, at_rest, run.scene.time.duration, true).seconds;
    if (arguments.modes > 0) {
        const ModesReport report = find_modes(at_rest, arguments.modes);
        seconds += report.seconds;
        solution.quantities = frequencies_of(report);
        solved.simulation->go_to_end([&](World&) { at_rest.show(run.scene.time.duration); });
        on_root(comm, [&] { write_file(out + "/modes.csv", to_csv(report)); });
    } else {
        solved.simulation->go_to_end([&](World&) { at_rest.show(run.scene.time.duration); });
    }
    const Machine& machine = solved.machine;
    solution.core_seconds = seconds * machine.ranks * std::min(machine.threads, machine.cores);
    return solution;
}

StudySolution solve_path(const Communicator& comm, const StudyRun& run, const ConvergeArguments& arguments,
                         const std::string& out) {
    PathArguments path = arguments.path;
    path.run = run_arguments(arguments, out);
    auto& overrides = path.run.scene.overrides;
    overrides.insert(overrides.end(), run.changes.begin(), run.changes.end());
    overrides.push_back(fmt::format("output.tips={:.17g}", run.scene.time.duration));
    overrides.push_back("output.precision=double");
    const FoundPath found = follow_path(comm, path);
    if (found.code != Exit::done) throw Stopped("stopped by a signal");
    if (!found.complete) throw NumericalError("the path ends early: " + found.reason);
    StudySolution solution{.core_seconds = found.seconds, .quantities = {}};
    for (const auto& [name, values] : {std::pair{"limit", &found.limits}, {"branch", &found.branches}})
        for (std::size_t i = 0; i < values->size(); ++i)
            solution.quantities.push_back(quantity(name, i, found.unit, (*values)[i]));
    return solution;
}

/// Keeps the quantities that all solutions have, in the same order; names of the others.
std::vector<std::string> keep_common(std::vector<StudySolution>& solutions) {
    std::map<std::string, std::size_t> count;
    std::vector<std::string> names, left_out;
    for (const StudySolution& solution : solutions)
        for (const Quantity& q : solution.quantities)
            if (++count[q.name] == 1) names.push_back(q.name);
    std::copy_if(names.begin(), names.end(), std::back_inserter(left_out),
                 [&](const std::string& name) { return count[name] < solutions.size(); });
    for (StudySolution& solution : solutions)
        std::erase_if(solution.quantities, [&](const Quantity& q) { return count[q.name] < solutions.size(); });
    return left_out;
}

} // namespace

StudyMethod method_of(const ConvergeArguments& arguments) {
    if (!arguments.path.key.empty()) return StudyMethod::path;
    if (arguments.modes > 0) return StudyMethod::modes;
    return arguments.equilibrium ? StudyMethod::equilibrium : StudyMethod::steps;
}

SolvedStudy solve_runs(const Communicator& comm, const Study& study, const ConvergeArguments& arguments,
                       const std::string& out) {
    std::vector<StudySolution> solutions;
    for (const StudyRun& run : study.made()) {
        const std::string directory = out + "/" + run.name;
        try {
            const Friction friction = solutions.empty() ? Friction::with_memory : Friction::told;
            solutions.push_back(study.method == StudyMethod::path
                                    ? solve_path(comm, run, arguments, directory)
                                    : solve_at_rest(comm, run, arguments, directory, friction));
        } catch (const Error& error) {
            throw Error(error.code(), "solution " + run.name + ": " + error.what());
        }
        if (comm.root()) {
            std::printf("  %s: %.3g core-seconds\n", run.name.c_str(), solutions.back().core_seconds);
            std::fflush(stdout);
        }
    }
    std::vector<std::string> left_out = keep_common(solutions);
    return {std::move(solutions), std::move(left_out)};
}

} // namespace skein
