#include "scene/make_plan.hpp"

#include "physics/plan_input.hpp"
#include "scene/make_groups.hpp"
#include "scene/scene_stages.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace skein {

SceneSpec resolved(SceneSpec scene, std::span<const RodGroup> groups) {
    PhysicsTables::resolve(scene, groups);
    return scene;
}

namespace {

/// Plan of a scene that is the same throughout, or of one stage.
Plan plan_of(const SceneSpec& as_written, std::span<const RodGroup> groups, const Machine& machine) {
    const SceneSpec scene = resolved(as_written, groups);
    PlannedPhysics physics;
    PhysicsTables::plan({scene, as_written, groups}, physics);
    return make_plan(scene, physics.take(), groups, machine);
}

/// The plan of a stage with the step of the whole run, s; 0: the stage's own.
Plan plan_of_stage(SceneSpec now, const std::string& name, double dt, std::span<const RodGroup> groups,
                   const Machine& machine) {
    const bool automatic = now.time.dt == 0;
    if (dt > 0) now.time.dt = dt;
    try {
        Plan plan = plan_of(now, groups, machine);
        plan.automatic_dt = automatic;
        return plan;
    } catch (const InputError& error) {
        if (name.empty()) throw;
        throw InputError(fmt::format("{}, in stage '{}'", error.what(), name));
    }
}

} // namespace

std::vector<RodGroup> groups_in_stage(const SceneSpec& scene, std::span<const double> begins,
                                      std::span<const RodGroup> like) {
    std::vector<RodGroup> groups = make_groups(scene, begins);
    for (std::size_t g = 0; g < groups.size(); ++g) groups[g].take_rods_of(like[g]);
    return groups;
}

Plan plan_in_stage(const SceneSpec& scene, std::span<const double> begins, double dt, std::span<const RodGroup> groups,
                   const Machine& machine) {
    const std::string name = scene.stages.empty() ? "" : scene.stages[begins.size() - 1].name;
    return plan_of_stage(stage_scene(scene, begins), name, dt, groups, machine);
}

namespace {

/// Throws InputError where the steps of a stage do not fit into those of the first one: outputs count the latter.
void refuse_other_events(const Plan& first, const Plan& plan, const StageSpec& stage) {
    if (plan.events_every == first.events_every) return;
    throw InputError(
        fmt::format("stage '{}': its bodies would all stand every {} steps, and in the first stage every {}: "
                    "give a 'dt' under which both are the same",
                    stage.name, plan.events_every, first.events_every));
}

} // namespace

Plan make_plan(const SceneSpec& as_written, std::span<const RodGroup> groups, const Machine& machine) {
    if (as_written.stages.empty()) return plan_of(as_written, groups, machine);
    const SceneSpec scene = resolved(as_written, groups);
    const auto in_stage = [&](std::size_t stage, double dt) {
        const std::vector<double> begins = nominal_begins(scene, stage);
        if (stage == 0) return plan_in_stage(scene, begins, dt, groups, machine);
        return plan_in_stage(scene, begins, dt, groups_in_stage(scene, begins, groups), machine);
    };
    Plan first = in_stage(0, 0);
    double dt = first.dt;
    std::size_t shortest = 0;
    for (std::size_t stage = 1; stage < scene.stages.size(); ++stage) {
        const Plan plan = in_stage(stage, 0);
        if (plan.dt < dt) shortest = stage;
        dt = std::min(dt, plan.dt);
    }
    if (shortest > 0 || first.events_every > 1) first = in_stage(0, dt);
    if (shortest > 0)
        first.divides = fmt::format("stage '{}', whose limit is the smallest", scene.stages[shortest].name);
    for (std::size_t stage = 1; stage < scene.stages.size() && first.events_every > 1; ++stage)
        refuse_other_events(first, in_stage(stage, dt), scene.stages[stage]);
    for (std::size_t stage = 0; stage < scene.stages.size(); ++stage)
        first.stages.push_back({scene.stages[stage].name, scene.stages[stage].duration, scene.stages[stage].until,
                                stage_changes(scene, stage)});
    return first;
}

} // namespace skein
