#include "commands.hpp"
#include "converge_solutions.hpp"
#include "document.hpp"

#include "core/timer.hpp"
#include "io/disk.hpp"
#include "io/files.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "simulation/machine.hpp"
#include "simulation/signals.hpp"
#include "studies/convergence_study.hpp"
#include "studies/convergence_text.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace skein {

namespace {

namespace fs = std::filesystem;

const std::string figures_name = "converge.json", table_name = "converge.csv";

/// Refuses a directory in which something else has the names of what will be written, before anything is run.
void require_own(const std::string& out) {
    const std::string figures = out + "/" + figures_name, table = out + "/" + table_name;
    const bool own = fs::is_regular_file(figures) &&
                     read_file(figures).find(std::string("\"format\": \"") + study_format + "\"") != std::string::npos;
    for (const std::string& file : {figures, table})
        if (fs::exists(file) && !own)
            throw IoError(file + ": is there already, and not from skein converge; use another --out");
    fs::create_directories(out);
}

/// Runs in the order in which they are made: cheap ones first.
std::vector<std::size_t> order_of(const Study& study) {
    std::vector<std::size_t> order;
    for (const std::size_t k : {std::size_t{0}, Study::half_step, std::size_t{1}, std::size_t{2}})
        if (k < study.made().size()) order.push_back(k);
    return order;
}

/// "run 2 of 4: 20 elements", and what the runs after it will cost.
PlaceAmongRuns place_of(const Study& study, std::span<const std::size_t> order, std::size_t number) {
    const StudyRun& run = study.runs[order[number]];
    double to_come = 0;
    for (const std::size_t later : order.subspan(number + 1)) to_come += study.runs[later].predicted;
    return {fmt::format("run {} of {}: {} elements", number + 1, order.size(), run.elements), to_come / run.predicted};
}

/// One run to its end, or from where it was stopped; of one that has ended nothing is made again.
RunResult make_run(const Communicator& comm, const Threads& threads, const Machine& machine, const StudyRun& run,
                   const std::string& out, const ConvergeArguments& arguments, PlaceAmongRuns place) {
    try {
        std::vector<RodGroup> groups = groups_for_all(comm, run.scene);
        Plan plan = make_plan(run.scene, groups, machine);
        RunOptions options;
        options.out = out + "/" + run.name;
        options.quiet = true;
        options.overwrite = arguments.overwrite;
        options.progress = arguments.progress;
        options.place = std::move(place);
        return Simulation(comm, threads, run.scene, std::move(groups), std::move(plan), options).run();
    } catch (const Error& error) {
        throw Error(error.code(), "run " + run.name + ": " + error.what());
    }
}

/// Makes the runs of a study, up to the first that is stopped; its code.
Exit make_runs(const Communicator& comm, const Machine& machine, const Study& study, const std::string& out,
               const ConvergeArguments& arguments) {
    const Threads threads(machine.threads);
    const std::vector<std::size_t> order = order_of(study);
    for (std::size_t number = 0; number < order.size(); ++number) {
        const StudyRun& run = study.runs[order[number]];
        const double began = wall_seconds();
        const RunResult result = make_run(comm, threads, machine, run, out, arguments, place_of(study, order, number));
        if (result.code == Exit::unsettled)
            throw Error(result.code, "run " + run.name + ": its rods have not settled; raise time.duration");
        if (result.code != Exit::done) {
            if (comm.root())
                std::printf("Stopped in the run %s at step %lld; the same command continues.\n", run.name.c_str(),
                            static_cast<long long>(result.step));
            return result.code;
        }
        if (comm.root()) {
            std::printf("  %s: %.3g s\n", run.name.c_str(), wall_seconds() - began);
            std::fflush(stdout);
        }
    }
    return Exit::done;
}

StudyFigures figures_of_runs(const Study& study, const SolvedStudy& solved, const std::string& out) {
    std::array<RunSamples, 4> samples;
    std::array<double, 4> core_seconds{};
    const std::vector<RodGroup> groups = make_groups(study.runs[study.given].scene);
    for (std::size_t k = 0; k < samples.size(); ++k) {
        const std::string directory = out + "/" + study.runs[k].name;
        samples[k] = read_samples(directory, groups, study.at_rest);
        if (!study.solved()) {
            core_seconds[k] = core_seconds_of(directory, study.runs[k].predicted);
            continue;
        }
        const StudySolution& solution = solved.solutions[k < solved.solutions.size() ? k : study.given];
        core_seconds[k] = solution.core_seconds;
        if (study.method == StudyMethod::modes) samples[k].quantities.clear(); // frequencies have the rest in them
        samples[k].quantities.insert(samples[k].quantities.end(), solution.quantities.begin(),
                                     solution.quantities.end());
    }
    StudyFigures figures = figures_of(study, samples, core_seconds);
    if (!solved.left_out.empty())
        figures.notes.push_back(fmt::format("not all solutions have {}{}", solved.left_out.front(),
                                            solved.left_out.size() > 1 ? ", ..., " + solved.left_out.back() : ""));
    return figures;
}

/// Writes and prints the figures of all runs; text of a name that no observable has, or none.
std::string tell_figures(const Study& study, const SolvedStudy& solved, const ConvergeArguments& arguments,
                         const std::string& out) {
    const StudyFigures figures = figures_of_runs(study, solved, out);
    std::optional<Advice> advice;
    std::string unknown;
    try {
        if (arguments.tolerance > 0) advice = advice_for(study, figures, arguments.tolerance, arguments.observables);
    } catch (const InputError& error) {
        unknown = error.what();
    }
    write_file(out + "/" + figures_name, to_json(study, figures, advice ? &*advice : nullptr));
    write_file(out + "/" + table_name, to_csv(study, figures));
    std::printf("%s%s", to_text(study, figures).c_str(), advice ? to_text(study, *advice).c_str() : "");
    std::printf("Figures: %s/%s, %s; a plot of error against core-seconds: apps/figures/converge.py %s\n", out.c_str(),
                figures_name.c_str(), table_name.c_str(), out.c_str());
    if (arguments.json) print_result(read_file(out + "/" + figures_name));
    return unknown;
}

nlohmann::ordered_json json_of_runs(const Study& study) {
    nlohmann::ordered_json runs = nlohmann::ordered_json::array();
    for (const StudyRun& run : study.made()) {
        runs.push_back({{"name", run.name}, {"elements", run.elements}});
        if (!study.solved())
            runs.back().update({{"dt_s", run.dt}, {"steps", run.steps}, {"predicted_core_seconds", run.predicted}});
    }
    return runs;
}

} // namespace

int converge_command(ConvergeArguments arguments, int& argc, char**& argv) {
    std::string beside; // a scene in a directory is of a branch, which is refused later
    look_into_directory(arguments.scene, beside);
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    stop_on_signals();
    return guarded(comm, [&] {
        const std::string text = text_for_all(comm, arguments.scene.file);
        const SceneSpec scene = parse_scene(arguments.scene.file, text, arguments.scene.overrides);
        const Machine machine = machine_of(comm, arguments.threads, arguments.lanes, arguments.mapping);
        const StudyMethod method = method_of(arguments);
        const Study study = method == StudyMethod::steps ? make_study(comm, machine, scene, arguments.coarser)
                                                         : make_solved_study(scene, method, arguments.coarser);
        std::string out = arguments.out;
        if (out.empty()) out = "out/" + fs::path(arguments.scene.file).stem().string() + "_converge";
        if (comm.root()) {
            std::printf("%s: %s that tell its errors, in %s\n%s", arguments.scene.file.c_str(),
                        study.solved() ? "solutions" : "runs", out.c_str(), runs_text(study).c_str());
            std::fflush(stdout);
        }
        if (arguments.dry_run && arguments.json && comm.root()) print_document(json_of_runs(study));
        if (arguments.dry_run) return static_cast<int>(Exit::done);
        on_root(comm, [&] { require_own(out); });
        SolvedStudy solved;
        if (study.solved()) solved = solve_runs(comm, study, arguments, out);
        else if (const Exit code = make_runs(comm, machine, study, out, arguments); code != Exit::done)
            return static_cast<int>(code);
        std::string unknown; // of a name that no observable has, told beside the table of those that there are
        on_root(comm, [&] { unknown = tell_figures(study, solved, arguments, out); });
        unknown = comm.broadcast(unknown);
        if (!unknown.empty()) throw InputError(unknown);
        return static_cast<int>(Exit::done);
    });
}

} // namespace skein
