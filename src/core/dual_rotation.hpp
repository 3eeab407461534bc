// Rotations of dual numbers beyond the reach of polynomials, and the turn of a frame along a direction.
#pragma once

#include "core/rotation.hpp"
#include "skein/core/dual_pack.hpp"

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

} // namespace detail

/// Frame R(u) Q about u = 0 that turns by the slopes of u, body.
SKEIN_INLINE Quaternion<Pack<dual>> turned_along(const Quaterniond& frame, const Vec3<Pack<dual>::Slopes>& slopes) {
    using P = Pack<dual>;
    const P::Slopes half(0.5);
    const Quaternion<P> turn{P(1.0), {P(0.0, half * slopes.x), P(0.0, half * slopes.y), P(0.0, half * slopes.z)}};
    return turn * Quaternion<P>{P(frame.w), {P(frame.v.x), P(frame.v.y), P(frame.v.z)}};
}

} // namespace skein
