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
            {"seconds", report.seconds},
            {"results", out}};
}

} // namespace

int equilibrium_command(EquilibriumArguments arguments, int& argc, char**& argv) {
    look_into_directory(arguments.run.scene, arguments.run.options.out);
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    stop_on_signals();
    return guarded(comm, [&] {
        const bool quiet = arguments.run.options.quiet;
        SolvedScene solved = solved_scene(comm, arguments.run, "_equilibrium", Friction::with_memory);
        StaticScene at_rest(solved.simulation->world());
        const double time = arguments.time >= 0 ? arguments.time : solved.scene.time.duration;
        const EquilibriumReport report = find_and_tell(solved, at_rest, time, quiet);
        solved.simulation->go_to_end([&](World&) { at_rest.put_back(); });
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
