// Shift of a group's lowest bending mode by scaled rotary inertia: an estimate for the plan. theory.md, end of section
// 9
#pragma once

#include "skein/rod/rod_group.hpp"

namespace skein {

/// Relative shift of the lowest bending frequency, from the mode of the slender uniform rod with the group's ends; 0
/// without scaling.
double bending_shift(const RodGroup& group);

} // namespace skein
