// Radii along a rod that a scene writes as formulas.
#pragma once

#include "formula/formula.hpp"
#include "skein/rod/rod_spec.hpp"

#include <string>
#include <vector>

namespace skein {

/// Gives a section that has formulas for its radii the profiles that they say: their values at the middles of elements.
/// Returns what is wrong with them by key of the section; its profiles are then as they were. Reads nothing where the
/// names have faults, which are told where they stand.
struct SectionFault {
    std::string key;
    FormulaFault fault;
};
std::vector<SectionFault> read_section(RodSpec& rods, const FormulaScope& names);

} // namespace skein
