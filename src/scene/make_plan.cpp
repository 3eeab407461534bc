#include "scene/make_plan.hpp"

#include "physics/plan_input.hpp"

#include <utility>

namespace skein {

SceneSpec resolved(SceneSpec scene, std::span<const RodGroup> groups) {
    PhysicsTables::resolve(scene, groups);
    return scene;
}

Plan make_plan(const SceneSpec& as_written, std::span<const RodGroup> groups, const Machine& machine) {
    const SceneSpec scene = resolved(as_written, groups);
    PlannedPhysics physics;
    PhysicsTables::plan({scene, as_written, groups}, physics);
    return make_plan(scene, physics.take(), groups, machine);
}

} // namespace skein
