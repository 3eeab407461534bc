// Groups of rods from a scene.
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/rod/rod_group.hpp"

#include <vector>

namespace skein {

/// The groups of a scene with their constants worked out. What files say of single rods is not read yet, unless rods
/// press.
std::vector<RodGroup> make_groups(const SceneSpec& scene);
/// Groups with all rods that their files hold.
std::vector<RodGroup> make_whole_groups(const SceneSpec& scene);

} // namespace skein
