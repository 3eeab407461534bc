// A rod held at its top, stretched by its own load and by a force on its end, far beyond small strain, with T = F + q
// (L - s):
//   incompressible, elastica   E A (e - 1)/e = T,   x(s) = (E A/q) ln[(E A - F - q (L - s))/(E A - F - q L)]
//   linear                     E A (e - 1) = T,     x(s) = s + [F s + q (L s - s^2/2)]/(E A)
#pragma once

#include "loads/end_force.hpp"
#include "loads/uniform_force.hpp"
#include "support/relaxation.hpp"

#include <numbers>

namespace skein::test::axial_stretching {

constexpr double radius = 0.1, area = std::numbers::pi * radius * radius; // L = rho = E = 1
constexpr double load = 0.3 * area, end_load = 0.15 * area;               ///< q L and F, N

/// Where the point s of the rod at rest ends up, m.
inline double place(Law law, double s) {
    if (law == Law::linear) return s + (end_load * s + load * (s - 0.5 * s * s)) / area;
    return area / load * std::log((area - end_load - load * (1 - s)) / (area - end_load - load));
}

inline SceneSpec scene(long n) {
    const double omega = 0.5 * std::numbers::pi *
                         (1 - (end_load + load) / area); // of the first axial wave, slower by the largest stretch
    return coming_to_rest(clamped_unit_rod(n, radius), omega,
                          {{.load = UniformForce{.force = {0, 0, load}, .ramp = {2 / omega}}},
                           {.load = EndForce{.end = {0, 0, end_load}, .ramp = {2 / omega}}}});
}

} // namespace skein::test::axial_stretching
