// Rotations of director frames. R(v) = exp(-[v]x) turns a frame by v (body components): Q <- R(v) Q; log(R(v)) = v.
// theory.md (5)-(7). No trigonometric call below 0.5 rad, no regularising constant: polynomials in theta^2, exact at 0.
// Beyond 0.5 rad the lanes concerned, and only they, take libm; a lane's bits never depend on its neighbours.
#pragma once

#include "core/vec3.hpp"

namespace skein {

/// sin(t)/t and (1 - cos t)/t^2.
template <class P> struct RotationFactors {
    P a, b;
};

namespace detail {
// Taylor series in x = t^2; first omitted term x^7/15! = 5e-17 at the limit.
inline constexpr double sin_over_t[] = {1.0, -1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800, 1.0 / 6227020800.0};
inline constexpr double versine_over_t2[] = {1.0 / 2,         -1.0 / 24,         1.0 / 720,           -1.0 / 40320,
                                             1.0 / 3628800.0, -1.0 / 479001600.0, 1.0 / 87178291200.0};
inline constexpr double small_angle_squared = 0.25;
// theta/(2 sin theta) in u = sin^2(theta/2) = (3 - tr R)/4, Chebyshev interpolant on [0, 1/16], relative error 8e-17.
inline constexpr double half_angle_over_sine[] = {0.5,
                                                  0.33333333333327964,
                                                  0.26666666668953337,
                                                  0.22857142482858064,
                                                  0.2031749093828675,
                                                  0.18469015808098327,
                                                  0.17087156828352568,
                                                  0.15333566989682387,
                                                  0.19674274848821818};
inline constexpr double small_log_argument = 0.0625; // theta = 0.505
// g = (1 - (theta/2) cot(theta/2))/theta^2 in theta^2, Chebyshev interpolant on [0, 0.26], relative error 6e-17.
inline constexpr double log_jacobian[] = {0.08333333333333333,   0.001388888888889459,   3.306878304321267e-05,
                                          8.267199959256508e-07, 2.0873653306203182e-08, 5.389875790575848e-10};
inline constexpr double small_jacobian_argument = 0.26;

RotationFactors<double> rotation_factors_libm(double angle_squared);
/// theta/(2 sin theta) from |R - R^T|/2 = sin theta and tr R.
double half_angle_over_sine_libm(double sine, double trace);
double log_jacobian_libm(double angle_squared);
} // namespace detail

template <int W> SKEIN_INLINE RotationFactors<Pack<W>> rotation_factors(Pack<W> angle_squared) {
    RotationFactors<Pack<W>> f{polynomial(angle_squared, detail::sin_over_t), polynomial(angle_squared, detail::versine_over_t2)};
    const Mask<W> large = angle_squared > Pack<W>(detail::small_angle_squared);
    if (any(large)) [[unlikely]]
        for (int i = 0; i < W; ++i)
            if (large[i]) {
                const auto exact = detail::rotation_factors_libm(angle_squared[i]);
                f.a.set(i, exact.a);
                f.b.set(i, exact.b);
            }
    return f;
}

/// R(v) = 1 - a [v]x + b [v]x^2.
template <int W> SKEIN_INLINE Mat3<Pack<W>> rotation(const Vec3<Pack<W>>& v) {
    using P = Pack<W>;
    const P xx = v.x * v.x, yy = v.y * v.y, zz = v.z * v.z;
    const auto [a, b] = rotation_factors(xx + yy + zz);
    const P bx = b * v.x, by = b * v.y;
    const P ax = a * v.x, ay = a * v.y, az = a * v.z;
    return {{fnma(b, yy + zz, P(1.0)), fma(bx, v.y, az), fma(bx, v.z, -ay)},
            {fma(bx, v.y, -az), fnma(b, xx + zz, P(1.0)), fma(by, v.z, ax)},
            {fma(bx, v.z, ay), fma(by, v.z, -ax), fnma(b, xx + yy, P(1.0))}};
}
inline Mat3d rotation(const Vec3d& v) {
    return lane(rotation(broadcast<1>(v)), 0);
}

/// log(A B^T): the rotation vector that takes frame B to frame A. |log| < pi.
template <int W> SKEIN_INLINE Vec3<Pack<W>> relative_rotation(const Mat3<Pack<W>>& a, const Mat3<Pack<W>>& b) {
    using P = Pack<W>;
    // R_ij = a_i . b_j;   sin(theta) u = -(R21 - R12, R02 - R20, R10 - R01)/2
    const Vec3<P> twice_sine{dot(a.d2, b.d3) - dot(a.d3, b.d2), dot(a.d3, b.d1) - dot(a.d1, b.d3), dot(a.d1, b.d2) - dot(a.d2, b.d1)};
    const P trace = dot(a.d1, b.d1) + dot(a.d2, b.d2) + dot(a.d3, b.d3);
    const P u = (P(3.0) - trace) * P(0.25);
    P factor = polynomial(u, detail::half_angle_over_sine);
    const Mask<W> large = u > P(detail::small_log_argument);
    if (any(large)) [[unlikely]] {
        const P sine = P(0.5) * norm(twice_sine);
        for (int i = 0; i < W; ++i)
            if (large[i]) factor.set(i, detail::half_angle_over_sine_libm(sine[i], trace[i]));
    }
    return factor * twice_sine;
}

/// g(theta) of the derivative of log, theory.md (7).
template <int W> SKEIN_INLINE Pack<W> log_jacobian(Pack<W> angle_squared) {
    Pack<W> g = polynomial(angle_squared, detail::log_jacobian);
    const Mask<W> large = angle_squared > Pack<W>(detail::small_jacobian_argument);
    if (any(large)) [[unlikely]]
        for (int i = 0; i < W; ++i)
            if (large[i]) g.set(i, detail::log_jacobian_libm(angle_squared[i]));
    return g;
}

} // namespace skein
