// Rest curvature that a scene writes as formulas of the place along the rod.
#pragma once

#include "formula/formula.hpp"
#include "skein/rod/rod_spec.hpp"

#include <vector>

namespace skein {

/// Gives a shape that has formulas for its rest curvature the profile that they say: their values at its vertices.
/// Returns what is wrong with them, part.formula of -1: with all; the shape is then as it was. Reads nothing where the
/// names have faults, which are told where they stand.
std::vector<FormulaFault> read_rest_curvature(Shape& shape, const FormulaScope& names);

} // namespace skein
