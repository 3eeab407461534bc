// Contradictions: what no single key shows to be wrong.
#pragma once

#include "physics/scene_spec.hpp"

#include <set>
#include <string>
#include <vector>

namespace skein {

struct Contradiction {
    std::string path; ///< of the key or table at fault: "rods.0.section.taper"
    std::string message;
    std::size_t begin = 0, length = 0; ///< part of the key's text that is at fault, in bytes; length 0: all of it
};

/// Keys that a valid scene has to set although they are at their defaults: those that contradictions() misses where
/// `given` holds none but the changed ones.
std::set<std::string> needed_keys(const SceneSpec& scene);

/// `given` holds the paths of all keys the scene sets, so that keys without use can be told from defaults.
std::vector<Contradiction> contradictions(const SceneSpec& scene, const std::set<std::string>& given);

/// Throws InputError with all contradictions, one per line.
void refuse_contradictions(const SceneSpec& scene, const std::set<std::string>& given);

} // namespace skein
