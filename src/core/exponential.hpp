// exp(-z) and (1 - exp(-z))/z over packs, for the exponential kick.                theory.md (22)
#pragma once

#include "skein/core/pack.hpp"

namespace skein {

namespace detail {
// Taylor series of exp(r), |r| <= ln(2)/2; first omitted term r^14/14! = 4e-18.
inline constexpr double exp_series[] = {
    1.0,        1.0,         1.0 / 2,      1.0 / 6,       1.0 / 24,       1.0 / 120,       1.0 / 720,
    1.0 / 5040, 1.0 / 40320, 1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800.0};
} // namespace detail

/// exp(x) with a relative error below 5e-16 for x in [-708, 709]; x is clamped outside.
template <int W> SKEIN_INLINE Pack<W> exp(Pack<W> x) {
    using P = Pack<W>;
    x = max(min(x, P(709.0)), P(-708.0));
    constexpr double to_nearest = 6755399441055744.0; // 1.5 * 2^52: its addition and subtraction round to whole numbers
    const P k = fma(x, P(1.4426950408889634), P(to_nearest)) - P(to_nearest);
    // ln 2 in two parts; the first has trailing zeros, so that k times it is exact
    const P r = fnma(k, P(1.9082149292705877e-10), fnma(k, P(0.693147180369123816490), x));
    return polynomial(r, detail::exp_series) * power_of_two(k);
}

/// exp(-z) and phi1(z) = (1 - exp(-z))/z for z >= 0.
template <int W> struct Decay { Pack<W> factor, mean; };

namespace detail {
// Chebyshev interpolant of phi1 on [0, 1], relative error 2e-17. It needs no division and cancels nothing at 0.
inline constexpr double mean_decay[] = {1.0,
                                        -0.4999999999999964,
                                        0.1666666666664944,
                                        -0.041666666663443576,
                                        0.008333333302138762,
                                        -0.0013888887104824001,
                                        0.0001984120502317959,
                                        -2.4800032289946006e-05,
                                        2.753231109497008e-06,
                                        -2.7289403227036547e-07,
                                        2.3200975871202737e-08,
                                        -1.3221480811326931e-09};

/// Lanes outside [0, 1], out of line: rates are seldom so large over one step, and only fourth-order schemes step back.
/// Above 1 nothing cancels in 1 - exp(-z). Below 0, phi1(z) = exp(-z) phi1(-z).
template <int W> [[gnu::noinline]] void decay_rarely(Pack<W> z, Decay<W>& d) {
    using P = Pack<W>;
    const P size = abs(z), mean = polynomial(size, mean_decay);
    const Mask<W> large = size > P(1.0), backwards = z < P(0.0);
    const P factor = select(large, exp(-size), fnma(size, mean, P(1.0)));
    const P forward = select(large, (P(1.0) - factor) / select(large, size, P(1.0)), mean);
    d.factor = select(backwards, P(1.0) / factor, factor);
    d.mean = select(backwards, forward / factor, forward);
}
} // namespace detail

template <int W> SKEIN_INLINE Decay<W> decay(Pack<W> z) {
    const Pack<W> mean = polynomial(z, detail::mean_decay);
    Decay<W> d{fnma(z, mean, Pack<W>(1.0)), mean};
    if (any((z > Pack<W>(1.0)) | (z < Pack<W>(0.0)))) [[unlikely]]
        detail::decay_rarely(z, d);
    return d;
}

/// Implicit midpoint: a = (2 - z)/(2 + z), 0 above z = 2, and b = (1 - a)/z, of two exponents for one division; z >= 0.
template <int W> struct TwoDecays { Decay<W> x, z; };
template <int W> SKEIN_INLINE TwoDecays<W> midpoint_decays(Pack<W> x, Pack<W> z) {
    using P = Pack<W>;
    const P inv_x = max(x, fma(P(0.5), x, P(1.0))),
            inv_z = max(z, fma(P(0.5), z, P(1.0))); // 1/b: 1 + z/2, or z above 2
    const P both = P(1.0) / (inv_x * inv_z), mean_x = both * inv_z, mean_z = both * inv_x;
    return {{max(P(0.0), fnma(x, mean_x, P(1.0))), mean_x}, {max(P(0.0), fnma(z, mean_z, P(1.0))), mean_z}};
}

} // namespace skein
