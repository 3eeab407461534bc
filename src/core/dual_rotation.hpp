// Rotations of dual numbers beyond the reach of polynomials, and the turn of a frame along a direction.
#pragma once

#include "core/rotation.hpp"
#include "skein/core/dual_pack.hpp"

#include <cstring>

namespace skein {

namespace detail {

// d cos(t)/d(t^2) = -sinc(t)/2,  d sinc(t)/d(t^2) = (cos(t) - sinc(t))/(2 t^2)
template <> inline void large_half_angle<dual>(const Pack<dual>& squared, HalfAngle<Pack<dual>>& f) {
    const double t = std::sqrt(squared.v), cosine = std::cos(t), sinc = std::sin(t) / t;
    f.cosine = with_slope(squared, cosine, -0.5 * sinc);
    f.sine_over = with_slope(squared, sinc, (cosine - sinc) / (2 * squared.v));
}

template <> inline void large_relative_rotation<dual>(const Pack<dual>& half_cosine, const Vec3<Pack<dual>>& half_sine,
                                                      RelativeRotation<Pack<dual>>& r) {
    using P = Pack<dual>;
    // A frame has two signs; the one with the smaller turn is taken.
    const bool other = half_cosine.v < 0;
    const P c = other ? -half_cosine : half_cosine, s = norm(half_sine);
    const double inv = 1 / (s.v * s.v + c.v * c.v);
    const P half(std::atan2(s.v, c.v), P::Slopes(inv) * (P::Slopes(c.v) * s.d - P::Slopes(s.v) * c.d));
    r.log = ((other ? P(-2.0) : P(2.0)) * half / s) * half_sine;
    r.jacobian = (P(1.0) - half * c / s) / (P(4.0) * half * half);
}

/// Derivative of c[0] + c[1] x + c[2] x^2 + ..., by Horner's rule.
template <int N> SKEIN_INLINE double slope_of_polynomial(double x, const double (&c)[N]) {
    double slope = 0;
    for (int i = N - 1; i > 0; --i) slope = detail::fma_of_one(slope, x, i * c[i]);
    return slope;
}

} // namespace detail

/// Frame R(u) Q about u = 0 that turns by the slopes of u, body.
SKEIN_INLINE Quaternion<Pack<dual>> turned_along(const Quaterniond& frame, const Vec3<Pack<dual>::Slopes>& slopes) {
    using S = Pack<dual>::Slopes;
    const S half(0.5), w(frame.w), x(frame.v.x), y(frame.v.y), z(frame.v.z);
    const Vec3<S> u{half * slopes.x, half * slopes.y, half * slopes.z};
    return {{frame.w, -(u.x * x + u.y * y + u.z * z)},
            {{frame.v.x, u.x * w + (u.z * y - u.y * z)},
             {frame.v.y, u.y * w + (u.x * z - u.z * x)},
             {frame.v.z, u.z * w + (u.y * x - u.x * y)}}};
}

/// log(A B^T) and g of its derivative, where a frame turns along three directions from its first on; it is fixed where
/// that is negative. Values are those of relative_rotation_and_jacobian().
///   half the turn as a quaternion (c, s):   A turns by u: dc = -u.s/2, ds = (c u - u x s)/2
///                                           B turns by u: dc =  u.s/2, ds = -(c u + u x s)/2
inline RelativeRotation<Pack<dual>> relative_rotation_along(const Quaterniond& a, int first_a, const Quaterniond& b,
                                                            int first_b) {
    using P = Pack<dual>;
    const double c = dot(a, b);
    const Vec3d s{fma(b.w, a.v.x, fma(-a.w, b.v.x, fma(a.v.y, b.v.z, -(a.v.z * b.v.y)))),
                  fma(b.w, a.v.y, fma(-a.w, b.v.y, fma(a.v.z, b.v.x, -(a.v.x * b.v.z)))),
                  fma(b.w, a.v.z, fma(-a.w, b.v.z, fma(a.v.x, b.v.y, -(a.v.y * b.v.x))))};
    alignas(P::Slopes) double slopes[4][directions] = {}; // of c and s
    const auto turn = [&](int first, double sign) {
        if (first < 0) return;
        const Vec3d half = 0.5 * s;
        const double own = sign * 0.5 * c, rows[4][3] = {{-sign * half.x, -sign * half.y, -sign * half.z},
                                                         {own, -half.z, half.y},
                                                         {half.z, own, -half.x},
                                                         {-half.y, half.x, own}};
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 3; ++j) slopes[i][first + j] = rows[i][j];
    };
    turn(first_a, 1);
    turn(first_b, -1);
    const auto along = [&](double value, int i) {
        P::Slopes d;
        std::memcpy(&d, slopes[i], sizeof d);
        return P(value, d);
    };
    const P half_cosine = along(c, 0);
    const Vec3<P> half_sine{along(s.x, 1), along(s.y, 2), along(s.z, 3)};
    const double versine = 1 - c;
    RelativeRotation<P> r;
    if (versine > detail::small_versine) {
        detail::large_relative_rotation(half_cosine, half_sine, r);
        return r;
    }
    const auto series = [&](const auto& coefficients) {
        return P(polynomial(Pack<1>(versine), coefficients)[0],
                 P::Slopes(-detail::slope_of_polynomial(versine, coefficients)) * half_cosine.d);
    };
    r.log = series(detail::angle_over_half_sine) * half_sine;
    r.jacobian = series(detail::log_jacobian);
    return r;
}

} // namespace skein
