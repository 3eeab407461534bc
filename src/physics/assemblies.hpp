// Groups of a scene that belong together.
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/placement/assembly.hpp"

#include <string>
#include <vector>

namespace skein {

/// Number of the scene's assembly of this name; -1: there is none.
int assembly_named(const SceneSpec& scene, const std::string& name);

/// Number of each group's assembly, -1: none. After the scene's own assemblies come those that joints make of
/// groups of none, which have one copy.
std::vector<int> assembly_of_groups(const SceneSpec& scene);

/// Its name: that of an [[assembly]], or of the groups that joints make one of.
std::string assembly_name(const SceneSpec& scene, int assembly);

} // namespace skein
