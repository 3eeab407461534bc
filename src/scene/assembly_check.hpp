// Assemblies and joints of a scene: what contradicts itself, and which groups belong together.
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/core/objections.hpp"
#include "skein/placement/assembly.hpp"

#include <vector>

namespace skein {

void check_assemblies(const SceneSpec& scene, Objections& objections);
void check_joints(const SceneSpec& scene, Objections& objections);

/// Of each group the number of its assembly, -1: none. Behind the scene's own assemblies come those that joints make of
/// groups of none, which have one copy.
std::vector<int> assembly_of_groups(const SceneSpec& scene);

/// Its name: that of an [[assembly]], or of the groups that joints make one of.
std::string assembly_name(const SceneSpec& scene, int assembly);

} // namespace skein
