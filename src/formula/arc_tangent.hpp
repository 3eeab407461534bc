// Angle of a point over packs.
#pragma once

#include "formula/lane_bits.hpp"

#include <limits>

namespace skein {

namespace detail {

// (atan(q) - q)/q^3 in q^2 on |q| <= tan(pi/8), minimax in the angle: relative error 2e-18.
inline constexpr double arc_tangent_series[] = {-0.333333333333332,   0.19999999999953677,  -0.14285714280200607,
                                                0.111111107835647,    -0.0909089776001229,  0.07692060260545314,
                                                -0.06663104722453317, 0.05847895650880346,  -0.050393404811000755,
                                                0.0380656596456817,   -0.017908622852068488};
inline constexpr double tan_of_eighth = 0.41421356237309503; ///< tangent of pi/8

/// Scales 0 <= small <= large so that the quotient of their sum and difference has all its bits. Two infinities become
/// 1 and 1; a single one makes 0 and 1.
template <int W> [[gnu::noinline]] void bring_near(Pack<W>& small, Pack<W>& large) {
    using P = Pack<W>;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const P scale = select(large > P(0x1p900), P(0x1p-600), select(large < P(0x1p-900), P(0x1p600), P(1.0)));
    const Mask<W> endless = large >= P(infinity), both = small >= P(infinity), nothing = large <= P(0.0);
    small = select(endless, select(both, P(1.0), P(0.0) * small), small * scale);
    large = select(endless | nothing, P(1.0), large * scale);
}

} // namespace detail

/// Angle of (x, y) from the x axis, with zeros and infinities as in C's atan2. Error: 0.75 units in the last place, or
/// 1.5 where one of both is subnormal.
template <int W> SKEIN_INLINE Pack<W> arc_tangent(const Pack<W>& y, const Pack<W>& x) {
    using P = Pack<W>;
    const P across = detail::size_of(x), up = detail::size_of(y);
    const Mask<W> steep = up > across;
    P small = select(steep, across, up), large = select(steep, up, across);
    if (any(!((large <= P(0x1p900)) & (large >= P(0x1p-900))))) [[unlikely]]
        detail::bring_near(small, large);
    // atan(small/large), or pi/4 + atan((small - large)/(small + large)), in two parts, the second of which is small.
    const Mask<W> middle = small > P(detail::tan_of_eighth) * large;
    const P sum = large + small, difference = small - large;
    const P top = select(middle, difference, small), bottom = select(middle, sum, large);
    const P top_low = select(middle, small - (difference + large), P(0.0)),
            bottom_low = select(middle, small - (sum - large), P(0.0));
    const P inverse = P(1.0) / bottom, q = top * inverse,
            q_low = (fnma(q, bottom, top) + fnma(q, bottom_low, top_low)) * inverse;
    const P z = q * q, more = fma(q * z, polynomial(z, detail::arc_tangent_series), fnma(z, q_low, q_low));
    // Angle n pi/4 + q + more: steep directions have pi/2 less this angle, directions to the left pi less it.
    const P eighths = select(middle, P(1.0), P(0.0)), from_x = select(steep, P(2.0) - eighths, eighths);
    const P side = detail::times_sign(P(1.0), x), n = fma(side, from_x, fnma(P(2.0), side, P(2.0)));
    const P signed_q = detail::times_sign(select(steep, -q, q), x),
            signed_more = detail::times_sign(select(steep, -more, more), x);
    const P high = fma(n, P(0x1.921fb54442d18p-1), signed_q);
    const P low = (fms(n, P(0x1.921fb54442d18p-1), high) + signed_q) + fma(n, P(0x1.1a62633145c07p-55), signed_more);
    return detail::times_sign(high + low, y);
}

} // namespace skein
