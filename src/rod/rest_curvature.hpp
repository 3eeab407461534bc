// Rest curvature from formulas of the place along the rod.
#pragma once

#include "formula/formula.hpp"
#include "skein/rod/rod_spec.hpp"

#include <vector>

namespace skein {

/// Sets the profile of a shape with formulas for its rest curvature to their values at its vertices. Returns the
/// faults, with part.formula -1 for a fault of all formulas; the shape then stays as it was. Nothing is read where the
/// names have faults; these are reported elsewhere.
std::vector<FormulaFault> read_rest_curvature(Shape& shape, const FormulaScope& names);

} // namespace skein
