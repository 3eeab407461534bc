#include "solving.hpp"

#include "core/memory.hpp"
#include "core/timer.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "simulation/machine.hpp"
#include "simulation/results_directory.hpp"
#include "simulation/signals.hpp"
#include "simulation/warnings.hpp"

#include <fmt/format.h>

#include <cstdio>

namespace skein {

namespace {

constexpr double bytes_per_element = 12e3; ///< stiffness, its pattern, and a factor of a band

/// Refuses scenes that take more memory than there is.
void refuse_parts(const Plan& plan, const Communicator& comm) {
    const int shares = plan.acts_between_rods() ? 1 : comm.size(); // rods that touch are on all ranks
    const double needed = bytes_per_element * static_cast<double>(plan.elements) / shares;
    if (needed > free_memory())
        throw InputError(
            fmt::format("the stiffness of {} elements takes about {:.3g} GB a rank, of which {:.3g} GB are "
                        "free: fewer rods, or time.relax = true, would do",
                        plan.elements, 1e-9 * needed, 1e-9 * free_memory()));
}

void warn_of_friction(const SceneSpec& scene, Friction acting) {
    if (acting == Friction::with_memory && has_friction(scene, slips_always))
        print_warning("friction that depends on the speed of slip is zero at rest: bodies that it slows creep to this "
                      "state");
}

} // namespace

int study_on_one_rank(const char* command, const RunArguments& arguments, double time, int& argc, char**& argv,
                      const std::function<void(const StudiedScene&, const Threads&)>& study) {
    SceneArguments scene = arguments.scene;
    std::string out;
    look_into_directory(scene, out);
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    stop_on_signals();
    return guarded(comm, [&] {
        if (comm.size() > 1)
            throw InputError(fmt::format("skein {} solves one scene on one rank: start it without mpirun", command));
        StudiedScene studied{comm,
                             {scene.file, read_scene_text(scene.file), scene.overrides},
                             machine_of(comm, arguments.threads, arguments.lanes, arguments.mapping),
                             time,
                             {}};
        const SceneText& text = studied.text;
        const SceneSpec first = parse_scene(text.file, text.text, text.overrides);
        warn_of_friction(first, Friction::with_memory);
        if (time < 0) studied.time = first.time.duration;
        if (!first.start.from.empty()) {
            RunArguments begins = arguments;
            begins.scene = scene;
            studied.begun =
                begun_bodies(solved_scene(comm, begins, {}, Friction::told, {}, Directory::none).simulation->world());
            require_held_as_placed(*static_case(first, studied.machine, studied.time), *studied.begun);
        }
        study(studied, Threads(studied.machine.threads));
        return static_cast<int>(Exit::done);
    });
}

void refuse_results(const Communicator& comm, const RunOptions& options, const std::string& out) {
    const std::string found = comm.root() && !options.overwrite ? result_in(out) : std::string();
    if (const std::string name = comm.broadcast(found); !name.empty())
        throw InputError(fmt::format("'{}' holds results ('{}'): use another --out, or --overwrite, which moves them "
                                     "to a folder of their own",
                                     out, name));
}

SolvedScene solved_scene(const Communicator& comm, const RunArguments& arguments, const std::string& suffix,
                         Friction friction, const std::function<void(SceneSpec&)>& change, Directory directory) {
    RunOptions options = arguments.options;
    options.began = wall_seconds();
    if (options.out.empty()) options.out = default_out(arguments.scene.file) + suffix;
    options.quiet = true;
    if (directory == Directory::none) options.out.clear();
    if (directory == Directory::begins) refuse_results(comm, options, options.out);
    auto [scene, groups] = prepare(comm, arguments.scene, nullptr);
    refuse_unsolvable(scene);
    scene.start.time = StartTime::zero; // a state of a run that is over will do, as loads have the time of the solution
    if (comm.root()) warn_of_friction(scene, friction);
    SolvedScene solved{scene, machine_of(comm, arguments.threads, arguments.lanes, arguments.mapping), {}, {}, {}};
    solved.threads = std::make_unique<Threads>(solved.machine.threads);
    if (change) {
        change(solved.scene);
        groups = {};
        groups = make_groups(solved.scene);
        read_rods(comm, groups);
    }
    Plan plan = make_plan(solved.scene, groups, solved.machine);
    refuse_parts(plan, comm);
    solved.out = options.out;
    solved.simulation =
        std::make_unique<Simulation>(comm, *solved.threads, solved.scene, std::move(groups), std::move(plan), options);
    return solved;
}

EquilibriumReport find_and_tell(const SolvedScene& solved, StaticScene& at_rest, double time, bool quiet) {
    const EquilibriumReport report = find_equilibrium(at_rest, time, {.friction = true}, !quiet);
    const Communicator& comm = solved.simulation->world().comm;
    if (comm.root() && !quiet) std::printf("%s", to_text(report).c_str());
    if (!report.found)
        throw NumericalError(fmt::format("no equilibrium was found: only {:.4g} of the loads are balanced; {}",
                                         report.share, report.reason));
    return report;
}

} // namespace skein
