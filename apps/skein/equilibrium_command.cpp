#include "document.hpp"
#include "solving.hpp"

#include "io/files.hpp"
#include "simulation/signals.hpp"

#include <nlohmann/json.hpp>

#include <cstdio>

namespace skein {

namespace {

nlohmann::ordered_json equilibrium_document(const EquilibriumReport& report, const std::string& out) {
    return {{"pieces", report.pieces},
            {"unknowns", report.unknowns},
            {"load_steps", report.load_steps},
            {"iterations", report.iterations},
            {"residual", report.residual},
            {"unstable_pieces", report.unstable},
            {"unknown_stability", report.unknown_stability},
            {"neutral_motions", report.neutral},
            {"factor", report.factor},
            {"factor_bytes", report.factor_bytes},
            {"seconds", report.seconds},
            {"results", out}};
}

nlohmann::ordered_json plan_document(const SolutionPlan& plan) {
    return {{"pieces", plan.pieces},
            {"unknowns", plan.unknowns},
            {"factor", plan.factor},
            {"factor_bytes", plan.factor_bytes},
            {"seconds_per_correction", plan.seconds}};
}

} // namespace

int equilibrium_command(EquilibriumArguments arguments, int& argc, char**& argv) {
    look_into_directory(arguments.run.scene, arguments.run.options.out);
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    stop_on_signals();
    return guarded(comm, [&] {
        const bool quiet = arguments.run.options.quiet;
        SolvedScene solved = solved_scene(comm, arguments.run, "_equilibrium", Friction::with_memory, {},
                                          arguments.dry_run ? Directory::none : Directory::begins);
        StaticScene at_rest(solved.simulation->world());
        const double time = arguments.time >= 0 ? arguments.time : solved.scene.time.duration;
        if (arguments.dry_run) {
            const SolutionPlan plan = plan_equilibrium(at_rest, time, {.friction = true});
            if (comm.root()) std::printf("%s", to_text(plan).c_str());
            if (comm.root() && arguments.run.json) print_document(plan_document(plan));
            return static_cast<int>(Exit::done);
        }
        const EquilibriumReport report = find_and_tell(solved, at_rest, time, quiet);
        solved.simulation->go_to_end([&](World&) { at_rest.show(time); });
        if (comm.root() && !quiet) std::printf("Written: %s\n", solved.out.c_str());
        if (comm.root() && arguments.run.json) print_document(equilibrium_document(report, solved.out));
        if (arguments.stable) require_stable(report);
        return static_cast<int>(Exit::done);
    });
}

int modes_command(ModesArguments arguments, int& argc, char**& argv) {
    look_into_directory(arguments.run.scene, arguments.run.options.out);
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    stop_on_signals();
    return guarded(comm, [&] { return find_and_write_modes(comm, arguments); });
}

int path_command(PathArguments arguments, int& argc, char**& argv) {
    look_into_directory(arguments.run.scene, arguments.run.options.out);
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    stop_on_signals();
    return guarded(comm, [&] { return follow_and_write_path(comm, arguments); });
}

} // namespace skein
