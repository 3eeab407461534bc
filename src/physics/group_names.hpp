// Names of groups of rods: their letters, and the groups that names in other tables mean.
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/core/objections.hpp"

#include <string>
#include <vector>

namespace skein {

/// Letters, digits, _ and -: what files and datasets can be called.
bool good_name(const std::string& name);

/// Null where there is none, which is told of `key`.
const RodSpec* group_named(const SceneSpec& scene, const std::string& name, Objections& objections,
                           const std::string& key);

/// True if a list of names, as of the key `rods`, includes a group; an empty list includes all.
bool names_group(const std::vector<std::string>& names, const std::string& group);

/// The groups that the key `rods` of a table stands for: all where it names none.
std::vector<const RodSpec*> acted_on(const SceneSpec& scene, const std::vector<std::string>& names,
                                     Objections& objections);

} // namespace skein
