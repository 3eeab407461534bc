// Change of the turn phi between two frames A and B while both turn by finite angles, without a remainder.
//   frames turn as   A' = C(a) A,   C(a) = (1 + [a]/2)^-1 (1 - [a]/2),   |a| = 2 tan(angle/2)
//   B A^T changes by -Bm [d] Am^T, with means of the matrices and d = B^T b - A^T a: of both Cayley vectors in the lab
//   phi' - phi = G d
// G follows from phi = (theta/sin theta) s by the product rule of differences: s, the sine of the turn along its axis,
// and its cosine are linear in the entries of B A^T. The factor is a function of the cosine, and has a difference
// quotient, of which no digit is lost where the turn hardly changes.   theory.md (119)
#pragma once

#include "core/rotation.hpp"

#include <cmath>

namespace skein {

/// Turn between two frames.
template <class P> struct TurnBetween {
    P half_cosine;     ///< not below 0
    Vec3<P> half_sine; ///< along its axis
    P factor;          ///< theta/sin(theta/2)
    Vec3<P> log;       ///< phi
    P jacobian;        ///< g of theory.md (7)
};

namespace detail {

/// theta/sin(theta/2) and g, from 1 - cos(theta/2).
inline void turn_factors(double versine, double& factor, double& jacobian) {
    if (versine <= small_versine) {
        factor = polynomial(Pack<1>(versine), angle_over_half_sine)[0];
        jacobian = polynomial(Pack<1>(versine), log_jacobian)[0];
        return;
    }
    const double cosine = 1 - versine, sine = std::sqrt(versine * (2 - versine)), half = std::atan2(sine, cosine);
    factor = 2 * half / sine;
    jacobian = (1 - half * cosine / sine) / (4 * half * half);
}

template <int W>
[[gnu::noinline, gnu::cold]] void large_turn_factors(const Pack<W>& versine, Pack<W>& factor, Pack<W>& jacobian) {
    for (int i = 0; i < W; ++i) {
        if (!(versine[i] > small_versine)) continue;
        double f, g;
        turn_factors(versine[i], f, g);
        factor.set(i, f);
        jacobian.set(i, g);
    }
}

/// Difference quotient of theta/sin(theta/2), whose derivative by 1 - cos(theta/2) is 2 g times its square.
inline double factor_quotient(double from, double to) {
    constexpr double apart = 0.05; // nearer values would lose digits in their difference
    double f[2], g;
    if (std::abs(to - from) > apart) {
        turn_factors(from, f[0], g);
        turn_factors(to, f[1], g);
        return (f[1] - f[0]) / (to - from);
    }
    // Gauss's rule of four points is exact to round-off over so short a way: the next singularity is at 2.
    constexpr double at[] = {0.06943184420297371, 0.33000947820757187},
                     weight[] = {0.17392742256872693, 0.32607257743127307};
    double sum = 0;
    for (int i = 0; i < 2; ++i)
        for (const double t : {at[i], 1 - at[i]}) {
            turn_factors(from + t * (to - from), f[0], g);
            sum += weight[i] * 2 * g * f[0] * f[0];
        }
    return sum;
}
template <int W>
[[gnu::noinline, gnu::cold]] void large_factor_quotients(const Pack<W>& from, const Pack<W>& to, Pack<W>& quotient) {
    for (int i = 0; i < W; ++i)
        if (from[i] > small_versine || to[i] > small_versine) quotient.set(i, factor_quotient(from[i], to[i]));
}

/// Difference quotient of a polynomial.
template <int W, int N> Pack<W> polynomial_quotient(const Pack<W>& from, const Pack<W>& to, const double (&c)[N]) {
    Pack<W> value(c[N - 1]), quotient = value;
    for (int k = N - 2; k > 0; --k) {
        value = fma(value, from, Pack<W>(c[k]));
        quotient = fma(quotient, to, value);
    }
    return quotient;
}

} // namespace detail

template <int W>
TurnBetween<Pack<W>> turn_between(const Quaternion<Pack<W>>& after, const Quaternion<Pack<W>>& before) {
    using P = Pack<W>;
    Quaternion<P> q = after * inverse(before);
    const Mask<W> other_sign = q.w < P(0.0);
    q = {abs(q.w), select(other_sign, -q.v, q.v)};
    const P versine = P(1.0) - q.w;
    TurnBetween<P> turn{
        q.w, q.v, polynomial(versine, detail::angle_over_half_sine), {}, polynomial(versine, detail::log_jacobian)};
    if (any(versine > P(detail::small_versine))) [[unlikely]]
        detail::large_turn_factors(versine, turn.factor, turn.jacobian);
    turn.log = turn.factor * turn.half_sine;
    return turn;
}

/// G of a turn that changes, from the means of both frames, as matrices.
template <int W> Mat3<Pack<W>> finite_turn(const TurnBetween<Pack<W>>& from, const TurnBetween<Pack<W>>& to,
                                           const Mat3<Pack<W>>& after, const Mat3<Pack<W>>& before) {
    using P = Pack<W>;
    using V = Vec3<P>;
    const P y0 = P(1.0) - from.half_cosine, y1 = P(1.0) - to.half_cosine;
    P quotient = detail::polynomial_quotient(y0, y1, detail::angle_over_half_sine);
    if (any((y0 > P(detail::small_versine)) | (y1 > P(detail::small_versine)))) [[unlikely]]
        detail::large_factor_quotients(y0, y1, quotient);
    // theta/sin theta = (theta/sin(theta/2))/(2 cos(theta/2)): its mean, and its quotient by cos theta
    const P sum = from.half_cosine + to.half_cosine, inverse = P(0.25) / (from.half_cosine * to.half_cosine);
    const P mean = inverse * fma(from.factor, to.half_cosine, to.factor * from.half_cosine);
    const P slope = P(-0.5) * inverse * fma(sum, quotient, from.factor + to.factor) / sum;
    const V sine = fma(from.half_cosine, from.half_sine, to.half_cosine * to.half_sine);
    // s' - s = cof(Bm, Am) d,   cos theta' - cos theta = m.d
    const P half(0.5);
    const V m = half * (cross(after.d1, before.d1) + cross(after.d2, before.d2) + cross(after.d3, before.d3));
    const auto row = [&](const V& a2, const V& a3, const V& b2, const V& b3, const P& s) {
        return fma(half * mean, cross(a2, b3) + cross(b2, a3), (slope * s) * m);
    };
    return {row(after.d2, after.d3, before.d2, before.d3, sine.x),
            row(after.d3, after.d1, before.d3, before.d1, sine.y),
            row(after.d1, after.d2, before.d1, before.d2, sine.z)};
}

/// a^T diag(s) b
template <class P> Mat3<P> transpose_product(const Mat3<P>& a, const Vec3<P>& s, const Mat3<P>& b) {
    const Vec3<P> r1 = s.x * b.d1, r2 = s.y * b.d2, r3 = s.z * b.d3;
    return {fma(a.d1.x, r1, fma(a.d2.x, r2, a.d3.x * r3)), fma(a.d1.y, r1, fma(a.d2.y, r2, a.d3.y * r3)),
            fma(a.d1.z, r1, fma(a.d2.z, r2, a.d3.z * r3))};
}

} // namespace skein
