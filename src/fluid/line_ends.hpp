// Lines of numbers whose second differences have known eigenvalues. theory.md (78)
#pragma once

#include <cmath>
#include <numbers>

namespace skein {

/// What numbers do at both ends of a line of n of them.
enum class LineEnds {
    periodic,
    gradient_zero, ///< half a cell beyond the outer numbers
    value_zero,    ///< there
    faces_zero     ///< the value is 0 one cell before the first number and at the last
};

/// Of the second difference, by number of the coefficient, 0 to n - 1; of `faces_zero` coefficient 0 is always 0.
inline double second_difference(int n, LineEnds ends, int k) {
    const double pi = std::numbers::pi, angle = ends == LineEnds::periodic     ? pi * k / n
                                                : ends == LineEnds::value_zero ? pi * (n - k) / (2.0 * n)
                                                                               : pi * k / (2.0 * n);
    return -4 * std::sin(angle) * std::sin(angle);
}

} // namespace skein
