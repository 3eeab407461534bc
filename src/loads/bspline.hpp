// Cubic B-spline on [0, 1] with evenly spaced inner knots, clamped at both ends, as published muscles use it. theory.md
// (40)
#pragma once

#include "skein/core/index.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace skein {

/// Sum of c_i N_i(s) by de Boor's recursion; `coefficients`: [m], m >= 4; s in [0, 1]. The curve passes through the
/// first and the last coefficient.
inline double cubic_bspline(std::span<const double> coefficients, double s) {
    const auto m = static_cast<int>(coefficients.size());
    const auto knot = [m](int i) { return std::clamp((i - 3) / static_cast<double>(m - 3), 0.0, 1.0); };
    const int span = std::min(m - 1, 3 + static_cast<int>(s * (m - 3)));
    std::array<double, 4> d{};
    for (int j = 0; j <= 3; ++j) nth(d, j) = nth(coefficients, span - 3 + j);
    for (int level = 1; level <= 3; ++level)
        for (int j = 3; j >= level; --j) {
            const double left = knot(span - 3 + j), right = knot(span + 1 + j - level), a = (s - left) / (right - left);
            nth(d, j) = (1 - a) * nth(d, j - 1) + a * nth(d, j);
        }
    return d[3];
}

} // namespace skein
