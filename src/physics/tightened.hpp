// Steps that stay stable where something slows a mode down or stiffens it.
#pragma once

#include <cmath>

namespace skein {

/// Drag at the velocity before the kick takes from the stable step: a mode of frequency w is stable while (h w/2)^2 + h
/// nu/2 < 1, with the scheme's own figures for 2. `half`: half of what the drag does in that step. theory.md (38)
inline double slowed(double step, double half) { return step * (std::sqrt(1 + half * half) - half); }

/// Stiffness adds to the square of a mode's frequency at most what it has over mass, 1/s^2. `rate`: 2 over the step.
/// theory.md (40c)
inline double stiffened(double rate, double stiffness) { return 2 / std::sqrt(rate * rate + stiffness); }

} // namespace skein
