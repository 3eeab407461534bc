#include "simulation/start.hpp"

#include "io/disk.hpp"
#include "scene/scene_stages.hpp"
#include "simulation/branch.hpp"
#include "simulation/start_check.hpp"
#include "simulation/warnings.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

namespace skein {

namespace {

/// True if the directory of results has checkpoints, from which a run resumes. Collective.
bool has_checkpoints(const Communicator& comm, const RunOptions& options) {
    bool some = false;
    on_root(comm, [&] {
        std::error_code error; // opening the directory reports what is wrong with it
        some = !options.overwrite && std::filesystem::is_directory(options.out, error) &&
               !numbered_files(options.out, "checkpoint_", ".h5").empty();
    });
    return comm.max(static_cast<std::int64_t>(some)) != 0;
}

} // namespace

namespace {

/// The state that a run begins with; a branch holds ends as its parent, until `rods` say otherwise.
struct Loaded : Start {
    std::vector<RodSpec> rods = {};
};

Loaded load_start(World& world, const Stages& stages, const SceneSpec& scene, const std::string& physics,
                  const RunOptions& options, const std::string& newest) {
    const Communicator& comm = world.comm;
    const std::vector<std::string> names = saved_names(world.interactions());
    const std::vector<double>& stage_begins = stages.begins();
    const auto accept = [&](const CheckpointInfo& info) {
        if (info.stage_begins.size() != stage_begins.size()) throw OtherStage{info.stage_begins, info.file};
        std::vector<RodSpec> rods = with_caught_ends(scene.rods, info.ancestry);
        if (!ends_alike(rods, stages.rods())) throw OtherEnds{std::move(rods), info.file};
    };
    Loaded start;
    if (!options.out.empty())
        start.found = read_checkpoint(comm, options.out, world.groups, world.rods(), physics, print_warning, names,
                                      accept, newest);
    else if (!options.from.empty())
        start.found = load_checkpoint(comm, options.from, world.groups, world.rods(), accept, names);
    start.resumes = start.found.has_value();
    if (!start.found && !scene.start.from.empty()) {
        Branched branched =
            begin_branch(comm, {scene, world.plan.dt, physics, stages.rods(), stage_begins.size(), newest},
                         world.groups, world.rods(), names, print_warning);
        start.found = std::move(branched.info);
        start.rods = std::move(branched.rods);
    }
    return start;
}

} // namespace

Start start_of(World& world, Stages& stages, const SceneSpec& scene, const std::string& physics,
               const RunOptions& options) {
    Loaded start;
    std::string newest; // that has not been found damaged
    for (bool loaded = false; !loaded;) {
        try {
            start = load_start(world, stages, scene, physics, options, newest);
            loaded = true;
        } catch (const OtherEnds& other) {
            newest = other.file;
            stages.hold_ends(other.rods, world);
        } catch (const OtherStage& other) {
            if (other.begins.empty() || other.begins.size() > scene.stages.size())
                throw InputError(fmt::format("{}: the state to begin with is of stage {} of another scene, and this "
                                             "scene has {}",
                                             scene.file, other.begins.size(), scene.stages.size()));
            newest = other.file;
            stages.enter(other.begins, world);
        }
    }
    if (!start.found) return start;
    if (start.found->stage_begins != stages.begins()) stages.enter(start.found->stage_begins, world);
    restore(world.interactions(), start.found->saved);
    world.clock = Clock(world.plan.dt, start.found->step, world.plan.integrator, start.found->shift);
    if (!start.rods.empty() && !ends_alike(start.rods, stages.rods())) stages.hold_ends(start.rods, world);
    if (stages.any()) stages.go_on(stages.begins(), world);
    if (start.found->shift != 0) world.plan.steps = std::max<std::int64_t>(1, world.clock.step_at(scene.time.duration));
    return start;
}

void refuse_bad_start(World& world, const SceneSpec& scene, const RunOptions& options) {
    if (!options.from.empty() || !scene.start.from.empty() || has_checkpoints(world.comm, options)) return;
    refuse_start(world.comm, world.threads, world.plan, world.groups, world.rods(), world.exposure(),
                 world.neighbourhood());
}

} // namespace skein
