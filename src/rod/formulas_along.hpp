// Formulas of the place along a rod that a scene writes: their values at some places of it.
#pragma once

#include "formula/formula.hpp"
#include "skein/rod/rod_spec.hpp"

#include <span>
#include <string>
#include <vector>

namespace skein {

/// [formula][place], of places over the length; empty where there are faults, which are appended: a formula that cannot
/// be read, varies with more than s and L, or is not finite somewhere.
std::vector<std::vector<double>> values_along(std::span<const std::string> texts, std::string_view unit,
                                              const Shape& shape, std::span<const double> places,
                                              const FormulaScope& names, std::vector<FormulaFault>& faults);

} // namespace skein
