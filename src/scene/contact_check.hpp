// Contradictions in contacts and walls.
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/core/objections.hpp"

namespace skein {

/// [contact] and [[contact_pair]]; `objections`: of the scene.
void check_contact(const SceneSpec& scene, Objections& objections);

/// [[wall]]; `objections`: of the scene.
void check_walls(const SceneSpec& scene, Objections& objections);

} // namespace skein
