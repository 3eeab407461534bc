// Lines of numbers whose second differences have known eigenvalues. theory.md (78)
#pragma once

#include <cmath>
#include <numbers>

namespace skein {

/// Condition at both ends of a line of n numbers.
enum class LineEnds {
    periodic,
    gradient_zero, ///< gradient 0 half a cell beyond the outer numbers
    value_zero,    ///< value 0 half a cell beyond the outer numbers
    faces_zero     ///< value 0 one cell before the first number, and at the last
};

/// Eigenvalue of the second difference for coefficient k, 0 to n - 1. Coefficient 0 of `faces_zero` is always 0.
inline double second_difference(int n, LineEnds ends, int k) {
    const double pi = std::numbers::pi, angle = ends == LineEnds::periodic     ? pi * k / n
                                                : ends == LineEnds::value_zero ? pi * (n - k) / (2.0 * n)
                                                                               : pi * k / (2.0 * n);
    return -4 * std::sin(angle) * std::sin(angle);
}

} // namespace skein
