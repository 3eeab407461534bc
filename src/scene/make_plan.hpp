// The plan of a scene.
#pragma once

#include "physics/scene_spec.hpp"
#include "plan/plan.hpp"

#include <span>

namespace skein {

/// The scene with a number in place of every one that stands for "auto". `groups`: with all of their rods.
SceneSpec resolved(SceneSpec scene, std::span<const RodGroup> groups);

/// Throws InputError where the step is beyond the limit (naming group, element and mode) unless the scene forces it.
Plan make_plan(const SceneSpec& scene, std::span<const RodGroup> groups, const Machine& machine);

} // namespace skein
