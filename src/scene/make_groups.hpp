// Groups of rods from a scene.
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/rod/rod_group.hpp"

#include <span>
#include <vector>

namespace skein {

/// The groups of a scene with their constants worked out. What files say of single rods is not read yet, unless rods
/// press.
/// A scene in stages gives the groups of its first stage.
std::vector<RodGroup> make_groups(const SceneSpec& scene);
/// Groups of stage begins.size() - 1; `begins`: times at which stages so far have begun, s.
std::vector<RodGroup> make_groups(const SceneSpec& scene, std::span<const double> begins);
/// Groups with all rods that their files hold.
std::vector<RodGroup> make_whole_groups(const SceneSpec& scene);

} // namespace skein
