// Numbers that planes with friction take from the rods that lie on them and from gravity.                   theory.md
// section 19
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/rod/rod_group.hpp"

#include <span>
#include <string>
#include <vector>

namespace skein {

/// The scene with a number in place of every automatic tolerance and slip speed.
SceneSpec with_plane_numbers(SceneSpec scene, std::span<const RodGroup> groups);

/// Planes whose tolerance holds rods above them; of a scene with numbers.
std::vector<std::string> plane_doubts(const SceneSpec& scene, std::span<const RodGroup> groups);

} // namespace skein
