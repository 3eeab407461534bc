// Rest curvature and radii of a rod from formulas of the place along it.
#pragma once

#include "formula/formula.hpp"
#include "skein/rod/rod_spec.hpp"

#include <string>
#include <vector>

namespace skein {

/// Sets the profile of a shape with formulas for its rest curvature to their values at its vertices. Returns the
/// faults, with part.formula -1 for a fault of all formulas; the shape then stays as it was. Nothing is read where the
/// names have faults; these are reported elsewhere.
std::vector<FormulaFault> read_rest_curvature(Shape& shape, const FormulaScope& names);

/// Sets the profiles of a section with formulas for its radii to their values at the middles of elements. Returns the
/// faults by key of the section; its profiles then stay as they were. Nothing is read where the names have faults;
/// these are reported elsewhere.
struct SectionFault {
    std::string key;
    FormulaFault fault;
};
std::vector<SectionFault> read_section(RodSpec& rods, const FormulaScope& names);

} // namespace skein
