#include "solving.hpp"

#include "core/timer.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "simulation/machine.hpp"

#include <fmt/format.h>

#include <cstdio>

namespace skein {

namespace {

/// Parts of a scene that act on bodies at rest, and that nothing here knows.
void refuse_unknown_parts(const Plan& plan) {
    if (plan.acts_between_rods())
        throw InputError("bodies that touch cannot be solved for yet: leave [contact] out, or run the scene to rest "
                         "with time.relax = true");
}

} // namespace

SolvedScene solved_scene(const Communicator& comm, const RunArguments& arguments, const std::string& suffix,
                         const std::function<void(SceneSpec&)>& change) {
    auto [scene, groups] = prepare(comm, arguments.scene);
    SolvedScene solved{scene, machine_of(comm, arguments.threads, arguments.lanes, arguments.mapping), {}, {}, {}};
    solved.threads = std::make_unique<Threads>(solved.machine.threads);
    if (change) {
        change(solved.scene);
        groups = {};
        groups = make_groups(solved.scene);
        read_rods(comm, groups);
    }
    Plan plan = make_plan(solved.scene, groups, solved.machine);
    refuse_unknown_parts(plan);
    RunOptions options = arguments.options;
    options.began = wall_seconds();
    if (options.out.empty()) options.out = default_out(arguments.scene.file) + suffix;
    options.quiet = true;
    solved.out = options.out;
    solved.simulation =
        std::make_unique<Simulation>(comm, *solved.threads, solved.scene, std::move(groups), std::move(plan), options);
    return solved;
}

EquilibriumReport find_and_tell(const SolvedScene& solved, StaticScene& at_rest, double time, bool quiet) {
    const EquilibriumReport report = find_equilibrium(at_rest, time, {});
    const Communicator& comm = solved.simulation->world().comm;
    if (comm.root() && !quiet) std::printf("%s", to_text(report).c_str());
    if (!report.found)
        throw NumericalError(
            fmt::format("no equilibrium was found: {:.4g} of the loads are borne; {}", report.share, report.reason));
    return report;
}

} // namespace skein
