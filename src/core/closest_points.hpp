// Closest points of two segments p1 + s d1 and p2 + t d2, for W pairs at once. theory.md (52) s and t lie in [0, 1].
// The quadratic |r + s d1 - t d2|^2, r = p1 - p2, is convex: the free minimum in s is clamped, then that in t, then s
// again. Parallel segments have a range of nearest s, namely all whose point projects onto the other segment. The
// middle of this range is taken. Segments without length are points. Below a sine of 1e-7 between the segments
// round-off decides, and the middle is taken too. Source: Ericson 2005, Real-Time Collision Detection, section 5.1.9.
// Cost: 90 flop and a division.
#pragma once

#include "skein/core/vec3.hpp"

namespace skein {

template <class P> struct ClosestPoints {
    P s, t;
    Vec3<P> apart;  ///< from the point on 1 to the point on 2, m
    P sine_squared; ///< squared sine of the angle between the segments; 0 where one has no length
    P first, last;  ///< range of s in which 1 lies beside 2; meaningful for near-parallel segments
};

template <int W> SKEIN_INLINE Pack<W> clamp01(Pack<W> x) { return min(max(x, Pack<W>(0.0)), Pack<W>(1.0)); }

template <int W> SKEIN_INLINE ClosestPoints<Pack<W>> closest_points(const Vec3<Pack<W>>& p1, const Vec3<Pack<W>>& d1,
                                                                    const Vec3<Pack<W>>& p2, const Vec3<Pack<W>>& d2) {
    using P = Pack<W>;
    const P zero(0.0), one(1.0), tiny(1e-60), parallel(1e-14);
    const Vec3<P> r = p1 - p2;
    const P a = dot(d1, d1), e = dot(d2, d2), b = dot(d1, d2), c = dot(d1, r), f = dot(d2, r);
    const P some_a = max(a, tiny), some_e = max(e, tiny), both = some_a * some_e,
            denominator = max(a * e - b * b, zero);
    const P some_denominator = max(denominator, parallel * both);
    const P inverse = one / (both * some_denominator); // one division for three quotients
    const P inv_a = some_e * some_denominator * inverse, inv_e = some_a * some_denominator * inverse;
    const P sine_squared = denominator * inv_a * inv_e;
    // Projections of the ends of 2 onto 1, in order, within 1.
    const P foot_first = -c * inv_a, foot_last = (b - c) * inv_a;
    const P first = clamp01(min(foot_first, foot_last)), last = clamp01(max(foot_first, foot_last));
    const P free = (b * f - c * e) * (both * inverse);
    P s = select(sine_squared > parallel, clamp01(free), P(0.5) * (first + last));
    const P t = clamp01(fma(b, s, f) * inv_e);
    s = clamp01(fma(b, t, -c) * inv_a);
    s = select(sine_squared > parallel, s, clamp01(P(0.5) * (first + last)));
    return {s, t, fma(t, d2, -r) - s * d1, sine_squared, first, last};
}

} // namespace skein
