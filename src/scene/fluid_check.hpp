// Contradictions in the fluid, and in scenes that have a fluid and no rods.
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/core/objections.hpp"

namespace skein {

/// [fluid]; `objections`: of the scene.
void check_fluid(const SceneSpec& scene, Objections& objections);

} // namespace skein
