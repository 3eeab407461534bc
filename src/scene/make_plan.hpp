// The plan of a scene.
#pragma once

#include "physics/scene_spec.hpp"
#include "plan/plan.hpp"

#include <span>
#include <vector>

namespace skein {

/// The scene with a number in place of every one that stands for "auto". `groups`: with all of their rods.
SceneSpec resolved(SceneSpec scene, std::span<const RodGroup> groups);

/// Plan of a scene; of one in stages, of its first stage, with the step that all of them can take.
/// Throws InputError where the step is beyond the limit (naming group, element and mode) unless the scene forces it.
Plan make_plan(const SceneSpec& scene, std::span<const RodGroup> groups, const Machine& machine);

/// Groups and plan of stage begins.size() - 1; `begins`: times at which stages so far have begun, s. `like`: groups of
/// another stage, whose rods these are. `dt`: step of the run, s.
std::vector<RodGroup> groups_in_stage(const SceneSpec& scene, std::span<const double> begins,
                                      std::span<const RodGroup> like);
Plan plan_in_stage(const SceneSpec& scene, std::span<const double> begins, double dt, std::span<const RodGroup> groups,
                   const Machine& machine);

} // namespace skein
