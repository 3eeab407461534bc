// Contradictions: what no single key shows to be wrong.
#pragma once

#include "scene/scene_spec.hpp"

#include <set>
#include <string>
#include <vector>

namespace skein {

struct Contradiction {
    std::string path; ///< of the key or table at fault: "rods.0.section.taper"
    std::string message;
    std::size_t begin = 0, length = 0; ///< part of the key's text that is at fault, in bytes; length 0: all of it
};

/// `given` holds the paths of all keys the scene sets, so that keys without use can be told from defaults.
std::vector<Contradiction> contradictions(const SceneSpec& scene, const std::set<std::string>& given);

} // namespace skein
