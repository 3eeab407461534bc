// Radii along a rod from formulas.
#pragma once

#include "formula/formula.hpp"
#include "skein/rod/rod_spec.hpp"

#include <string>
#include <vector>

namespace skein {

/// Sets the profiles of a section with formulas for its radii to their values at the middles of elements. Returns the
/// faults by key of the section; its profiles then stay as they were. Nothing is read where the names have faults;
/// these are reported elsewhere.
struct SectionFault {
    std::string key;
    FormulaFault fault;
};
std::vector<SectionFault> read_section(RodSpec& rods, const FormulaScope& names);

} // namespace skein
