// Cost of explicit and of implicit steps of a scene whose rods touch each other or walls that servos drive, from some
// steps of the whole scene by each method.                                                         docs/long_steps.md
#pragma once

#include "physics/scene_spec.hpp"
#include "plan/method_costs.hpp"
#include "plan/plan.hpp"
#include "skein/rod/rod_group.hpp"

#include <optional>
#include <span>
#include <vector>

namespace skein {

/// The scene by this integrator with steps of this length, s; 0: automatic ones.
SceneSpec with_integrator(SceneSpec scene, Integrator integrator, double dt = 0);
/// False where implicit steps refuse the scene.
bool accepts_integrator(const SceneSpec& scene);

/// Plan of a scene by one of the methods, and its groups. Implicit steps give each copy of an assembly a lane, so that
/// joined groups differ between methods.
struct PlannedMethod {
    /// `groups`: of the scene by another method.
    PlannedMethod(const SceneSpec& scene, std::span<const RodGroup> groups, const Machine& machine);
    /// The scene by its own method.
    PlannedMethod(Plan plan, std::span<const RodGroup> groups);
    PlannedMethod(PlannedMethod&&) = default; // a copy would have the groups of another
    PlannedMethod& operator=(PlannedMethod&&) = default;

    std::vector<RodGroup> made; ///< for this method; empty where others serve
    std::span<const RodGroup> groups;
    Plan plan;
};

/// True of rods that cannot be tried one by one.
bool rods_touch(const SceneSpec& scene);

/// Costs of the scene by explicit steps and by its own implicit ones, or, where it has none, by those of a bed or
/// damped ones, whichever are cheaper. None where one of them fails. In this process alone.
std::optional<MethodCosts> touching_costs(const Plan& own, const SceneSpec& scene, std::span<const RodGroup> groups);

} // namespace skein
