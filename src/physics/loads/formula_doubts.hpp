// Formulas that are finite wherever they are looked at, and have a pole between two steps.
#pragma once

#include "physics/scene_spec.hpp"

#include <string>
#include <vector>

namespace skein {

/// One sentence each: a denominator that depends on time alone, is 0 at some time of the run, and takes the formula
/// with it.
std::vector<std::string> formula_doubts(const SceneSpec& scene);

} // namespace skein
