// What a scene may not have whose rods relax (theory.md section 21): all that depends on time, on velocities or on true
// inertia.
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/core/objections.hpp"

#include <span>

namespace skein {

/// `loads`: those of the scene, whose formulas have been read; `objections`: of the scene.
void check_relax(const SceneSpec& scene, std::span<const Load> loads, Objections& objections);

} // namespace skein
