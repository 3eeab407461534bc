// Cost of explicit and of implicit steps of the same scene, from trials of both on some rods of each group. The rods of
// the run itself stay untouched.                                                                   docs/long_steps.md
#pragma once

#include "physics/scene_spec.hpp"
#include "plan/plan.hpp"

#include <span>

namespace skein {

/// True of rods that may step either way, and take implicit steps or are predicted to need two seconds.
bool methods_are_compared(const Plan& plan, const SceneSpec& scene, std::span<const RodGroup> groups);

/// Makes both trials where explicit steps are predicted to need two seconds. Adds their costs to the plan, and puts
/// the time of its own method in place of the prediction. It takes about a quarter of a second at most, and a fiftieth
/// of the run by explicit steps. In this process alone, after MPI has begun.
void compare_methods(Plan& plan, const SceneSpec& scene, std::span<const RodGroup> groups);

} // namespace skein
