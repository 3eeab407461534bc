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
    return plan_of_stage(stage_scene(scene, begins), scene.stages[begins.size() - 1].name, dt, groups, machine);
}

Plan make_plan(const SceneSpec& scene, std::span<const RodGroup> groups, const Machine& machine) {
    if (scene.stages.empty()) return plan_of(scene, groups, machine);
    const auto begins = [&](std::size_t stage) { return nominal_begins(scene, stage); };
    Plan first = plan_in_stage(scene, begins(0), 0, groups, machine);
    double dt = first.dt;
    std::size_t shortest = 0;
    for (std::size_t stage = 1; stage < scene.stages.size(); ++stage) {
        const Plan plan =
            plan_in_stage(scene, begins(stage), 0, groups_in_stage(scene, begins(stage), groups), machine);
        if (plan.dt < dt) shortest = stage;
        dt = std::min(dt, plan.dt);
    }
    if (shortest > 0) {
        first = plan_in_stage(scene, begins(0), dt, groups, machine);
        first.divides = fmt::format("stage '{}', whose limit is the smallest", scene.stages[shortest].name);
    }
    for (std::size_t stage = 0; stage < scene.stages.size(); ++stage)
        first.stages.push_back({scene.stages[stage].name, scene.stages[stage].duration, scene.stages[stage].until,
                                stage_changes(scene, stage)});
    return first;
}

} // namespace skein
