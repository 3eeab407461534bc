// A number of a scene by its path, with its unit: what a path of equilibria follows and a fit finds.
#pragma once

#include "physics/scene_spec.hpp"

#include <span>
#include <string>
#include <vector>

namespace skein {

struct SceneNumber {
    double value = 0;
    std::string unit;   ///< of SI, "-" of a pure number; empty: none is known
    bool whole = false; ///< it counts something
    /// "load.0.end.2[N]"
    std::string heading(const std::string& path) const { return unit.empty() ? path : path + "[" + unit + "]"; }
};
/// Numbers under paths as --set has them, given or by default. Throws InputError where one is none.
std::vector<SceneNumber> numbers_at(const SceneSpec& scene, std::span<const std::string> paths);
SceneNumber number_at(const SceneSpec& scene, const std::string& path);

/// The scene with another value of such a number, which does not count anything. Throws InputError where the key does
/// not accept the value; contradictions of keys are not looked for.
SceneSpec with_number(SceneSpec scene, const std::string& path, double value);

/// Throws InputError for numbers that count something, such as elements: what is unknown changes with them.
void refuse_whole(const SceneNumber& number, const std::string& path);

} // namespace skein
