// A number of a scene by its path, with its unit: what a path of equilibria follows and a fit finds.
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/core/fields.hpp"

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
/// Numbers under paths as --set has them, given or by default; where a value stands for a number that follows from
/// other keys, this number. Throws InputError where one is none, or none that can be told.
std::vector<SceneNumber> numbers_at(const SceneSpec& scene, std::span<const std::string> paths);
SceneNumber number_at(const SceneSpec& scene, const std::string& path);

/// True where a value of a key is no number, but stands for one that follows from other keys or for none at all:
/// "auto", and what the text of the key describes as "0: ...", "0 stands for ..." or "below 0: ...".
bool is_placeholder(const Field& field, double value);

/// The scene with another value of such a number, which does not count anything. Throws InputError where the key does
/// not accept the value, or has it as a placeholder; contradictions of keys are not looked for.
SceneSpec with_number(SceneSpec scene, const std::string& path, double value);

/// Throws InputError for numbers that count something, such as elements: what is unknown changes with them; and for
/// the time of the solution itself.
void refuse_whole(const SceneNumber& number, const std::string& path);

} // namespace skein
