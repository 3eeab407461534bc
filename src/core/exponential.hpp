// exp(-z) and (1 - exp(-z))/z over packs, for the exponential kick.                theory.md (22)
#pragma once

#include "core/pack.hpp"

namespace skein {

namespace detail {
// Taylor series of exp(r), |r| <= ln(2)/2; first omitted term r^14/14! = 4e-18.
inline constexpr double exp_series[] = {1.0,       1.0,        1.0 / 2,       1.0 / 6,        1.0 / 24,        1.0 / 120,        1.0 / 720,
                                        1.0 / 5040, 1.0 / 40320, 1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800.0};
} // namespace detail

/// exp(x), relative error below 3e-16 for x in [-708, 709]; clamped outside.
template <int W> inline Pack<W> exp(Pack<W> x) {
    using P = Pack<W>;
    x = max(min(x, P(709.0)), P(-708.0));
    constexpr double to_nearest = 6755399441055744.0; // 1.5 * 2^52: adding and subtracting rounds to whole numbers
    const P k = fma(x, P(1.4426950408889634), P(to_nearest)) - P(to_nearest);
    // ln 2 in two parts, the first with trailing zeros so that k times it is exact
    const P r = fnma(k, P(1.9082149292705877e-10), fnma(k, P(0.693147180369123816490), x));
    return polynomial(r, detail::exp_series) * power_of_two(k);
}

/// exp(-z) and phi1(z) = (1 - exp(-z))/z for z >= 0.
template <int W> struct Decay {
    Pack<W> factor, mean;
};
template <int W> inline Decay<W> decay(Pack<W> z) {
    using P = Pack<W>;
    const P factor = exp(-z);
    // Below 0.02 the difference cancels; the first omitted term of the series, z^6/5040, is 1.3e-14 there.
    constexpr double series[] = {1.0, -1.0 / 2, 1.0 / 6, -1.0 / 24, 1.0 / 120, -1.0 / 720};
    const Mask<W> small = z < P(0.02);
    const P safe = select(small, P(1.0), z);
    return {factor, select(small, polynomial(z, series), (P(1.0) - factor) / safe)};
}

} // namespace skein
