// Names of groups of rods: which are names, and whom those in other tables mean.
#pragma once

#include "scene/scene_spec.hpp"
#include "skein/core/objections.hpp"

#include <string>
#include <vector>

namespace skein {

/// Letters, digits, _ and -: what files and datasets can be called.
bool good_name(const std::string& name);

/// Null where there is none, which is told of `key`.
const RodSpec* group_named(const SceneSpec& scene, const std::string& name, Objections& objections, const std::string& key);

/// The groups that the key `rods` of a table stands for: all where it names none.
std::vector<const RodSpec*> acted_on(const SceneSpec& scene, const std::vector<std::string>& names, Objections& objections);

} // namespace skein
