// A number of a scene by its path, with its unit: what a path of equilibria follows and a fit finds.
#pragma once

#include "physics/scene_spec.hpp"

#include <string>

namespace skein {

struct SceneNumber {
    double value = 0;
    std::string unit;   ///< of SI, "-" of a pure number; empty: none is known
    bool whole = false; ///< it counts something
    /// "load.0.end.2[N]"
    std::string heading(const std::string& path) const { return unit.empty() ? path : path + "[" + unit + "]"; }
};
/// Number under a path as --set has it, given or by default. Throws InputError where it is none.
SceneNumber number_at(const SceneSpec& scene, const std::string& path);

/// Throws InputError for numbers that count something, such as elements: what is unknown changes with them.
void refuse_whole(const SceneNumber& number, const std::string& path);

} // namespace skein
