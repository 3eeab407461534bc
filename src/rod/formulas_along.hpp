// Values of formulas of the place along a rod.
#pragma once

#include "formula/formula.hpp"
#include "skein/rod/rod_spec.hpp"

#include <span>
#include <string>
#include <vector>

namespace skein {

/// Values [formula][place] at places over the length. Faults are appended, and nothing is returned then. A formula must
/// be readable, depend on s and L alone, and be finite.
std::vector<std::vector<double>> values_along(std::span<const std::string> texts, std::string_view unit,
                                              const Shape& shape, std::span<const double> places,
                                              const FormulaScope& names, std::vector<FormulaFault>& faults);

} // namespace skein
