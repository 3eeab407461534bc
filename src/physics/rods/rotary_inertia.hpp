// Rotary inertia by "auto" in a scene: where it is refused, and what it chooses.          theory.md, end of section 9
#pragma once

#include "physics/scene_spec.hpp"
#include "rod/automatic_inertia.hpp"

#include <string>

namespace skein {

/// The choice for a group of a scene. A free end with a joint counts as pinned: no support makes less error.
AutomaticInertia automatic_inertia(const SceneSpec& scene, const RodSpec& rods);

/// Why the motion of these rods depends on rotary inertia, whatever is chosen; empty: nothing says so.
std::string rotary_inertia_matters(const SceneSpec& scene, const RodSpec& rods);

/// Cause, in words, that drives these rods faster, or in shorter waves, than bending is right to 1 % with `chosen`;
/// empty: there is none.
std::string driven_beyond(const SceneSpec& scene, const RodSpec& rods, const AutomaticInertia& chosen);

} // namespace skein
