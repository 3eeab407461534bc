#include "commands.hpp"
#include "document.hpp"

#include "core/timer.hpp"
#include "scene/make_plan.hpp"
#include "simulation/machine.hpp"
#include "simulation/signals.hpp"
#include "studies/equilibrium_study.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>

namespace skein {

int equilibrium_command(EquilibriumArguments arguments, int& argc, char**& argv) {
    look_into_directory(arguments.run.scene, arguments.run.options.out);
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    stop_on_signals();
    return guarded(comm, [&] {
        auto [scene, groups] = prepare(comm, arguments.run.scene);
        const Machine machine = machine_of(comm, arguments.run.threads, arguments.run.lanes, arguments.run.mapping);
        const Threads threads(machine.threads);
        Plan plan = make_plan(scene, groups, machine);
        RunOptions options = arguments.run.options;
        options.began = wall_seconds();
        if (options.out.empty()) options.out = default_out(arguments.run.scene.file) + "_equilibrium";
        const bool quiet = options.quiet;
        options.quiet = true;
        Simulation simulation(comm, threads, scene, std::move(groups), std::move(plan), options);
        StaticScene at_rest(simulation.world());
        const double time = arguments.time >= 0 ? arguments.time : scene.time.duration;
        const EquilibriumReport report = find_equilibrium(at_rest, time, {});
        if (comm.root() && !quiet) std::printf("%s", to_text(report).c_str());
        if (!report.found)
            throw NumericalError(
                fmt::format("no equilibrium was found beyond {:.4g} of the loads: {}", report.share, report.reason));
        simulation.go_to_end([&](World&) { at_rest.put_back(); });
        return static_cast<int>(arguments.stable && report.unstable > 0 ? Exit::unstable : Exit::done);
    });
}

} // namespace skein
