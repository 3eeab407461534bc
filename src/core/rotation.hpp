// Rotations of director frames. theory.md (5)-(7) R(u) = exp(-[u]x) turns a frame by u (body components): Q <- R(u) Q;
// log(R(u)) = u. Short polynomials, exact at 0, need no trigonometric call below 0.5 rad and no regularising constant.
// Lanes beyond 0.5 rad, and only they, call libm. Bits of a lane never depend on its neighbours.
#pragma once

#include "skein/core/quaternion.hpp"

namespace skein {

namespace detail {
// Chebyshev interpolants in t^2 on [0, 1/16], relative errors 1e-16 and 1e-18: the length of a quaternion is safe.
inline constexpr double sin_over_t[] = {1.0, -0.16666666666662938, 0.008333333328559567, -0.0001984124845280886,
                                        2.751820077874892e-06};
inline constexpr double cos_t[] = {1.0,
                                   -0.49999999999999994,
                                   0.04166666666665361,
                                   -0.0013888888879977843,
                                   2.4801559801962674e-05,
                                   -2.751820049899299e-07};
inline constexpr double small_half_angle_squared = 0.0625;
// Interpolants in y = 1 - cos(theta/2) on [0, 0.0315], relative errors 2e-17 and 9e-16: theta/sin(theta/2), and g = (1
// - (theta/2) cot(theta/2))/theta^2. In y the nearest singularity is twice as far away as in sin^2.
inline constexpr double angle_over_half_sine[] = {2.0,
                                                  0.6666666666666055,
                                                  0.2666666666977388,
                                                  0.11428570837635194,
                                                  0.05079418533517184,
                                                  0.0230632564867441,
                                                  0.011221973979824145};
inline constexpr double log_jacobian[] = {0.08333333333333326,   0.011111111111274509,  0.003968253907799806,
                                          0.0016225831266631831, 0.0007022969664983092, 0.0003282276859988743};
inline constexpr double small_versine = 0.0315; // theta = 0.503
} // namespace detail

/// cos t and sin(t)/t of half an angle t.
template <class P> struct HalfAngle { P cosine, sine_over; };

namespace detail {
/// Computes lanes beyond the reach of the polynomials. Packs go by reference, because passing wide packs by value
/// depends on the instruction level.
template <int W> [[gnu::noinline, gnu::cold]] void large_half_angle(const Pack<W>& squared, HalfAngle<Pack<W>>& f);
} // namespace detail

template <int W> SKEIN_INLINE HalfAngle<Pack<W>> half_angle(Pack<W> squared) {
    HalfAngle<Pack<W>> f{polynomial(squared, detail::cos_t), polynomial(squared, detail::sin_over_t)};
    if (any(squared > Pack<W>(detail::small_half_angle_squared))) [[unlikely]] {
        const Pack<W> argument = squared; // copies, so that values used elsewhere need not be in memory
        HalfAngle<Pack<W>> all = f;
        detail::large_half_angle(argument, all);
        f = all;
    }
    return f;
}

/// R(u) from u/2.
template <int W> SKEIN_INLINE Quaternion<Pack<W>> rotation_by_twice(const Vec3<Pack<W>>& half) {
    const HalfAngle<Pack<W>> f = half_angle(dot(half, half));
    return {f.cosine, f.sine_over * half};
}
template <int W> SKEIN_INLINE Quaternion<Pack<W>> rotation(const Vec3<Pack<W>>& u) {
    return rotation_by_twice(Pack<W>(0.5) * u);
}
inline Quaterniond rotation(const Vec3d& u) { return lane(rotation(broadcast<1>(u)), 0); }

/// log(A B^T), the rotation vector from frame B to frame A, |log| < pi; and g of its derivative, theory.md (7).
template <class P> struct RelativeRotation {
    Vec3<P> log;
    P jacobian;
};

namespace detail {
template <int W> [[gnu::noinline, gnu::cold]] void
large_relative_rotation(const Pack<W>& half_cosine, const Vec3<Pack<W>>& half_sine, RelativeRotation<Pack<W>>& r);
} // namespace detail

template <int W> SKEIN_INLINE RelativeRotation<Pack<W>> relative_rotation_and_jacobian(const Quaternion<Pack<W>>& a,
                                                                                       const Quaternion<Pack<W>>& b) {
    using P = Pack<W>;
    const P half_cosine = dot(a, b);
    const Vec3<P> half_sine{fma(b.w, a.v.x, fnma(a.w, b.v.x, fma(a.v.y, b.v.z, -(a.v.z * b.v.y)))),
                            fma(b.w, a.v.y, fnma(a.w, b.v.y, fma(a.v.z, b.v.x, -(a.v.x * b.v.z)))),
                            fma(b.w, a.v.z, fnma(a.w, b.v.z, fma(a.v.x, b.v.y, -(a.v.y * b.v.x))))};
    const P versine = P(1.0) - half_cosine;
    RelativeRotation<P> r{polynomial(versine, detail::angle_over_half_sine) * half_sine,
                          polynomial(versine, detail::log_jacobian)};
    if (any(versine > P(detail::small_versine))) [[unlikely]] {
        const P cosine = half_cosine;
        const Vec3<P> sine = half_sine;
        RelativeRotation<P> all = r;
        detail::large_relative_rotation(cosine, sine, all);
        r = all;
    }
    return r;
}
template <int W>
SKEIN_INLINE Vec3<Pack<W>> relative_rotation(const Quaternion<Pack<W>>& a, const Quaternion<Pack<W>>& b) {
    return relative_rotation_and_jacobian(a, b).log;
}
inline Vec3d relative_rotation(const Quaterniond& a, const Quaterniond& b) {
    return lane(relative_rotation(broadcast<1>(a), broadcast<1>(b)), 0);
}

} // namespace skein
