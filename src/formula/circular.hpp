// Sine and cosine over packs, for any angle. All widths give the same bits: a lane depends on its own number alone.
#pragma once

#include "formula/lane_bits.hpp"
#include "formula/large_angle.hpp"

namespace skein {

namespace detail {

// (sin(r) - r)/r^3 and (cos(r) - 1)/r^2 in r^2 on |r| <= pi/4, minimax: relative errors 4e-18 of the sine and 1e-18 of
// the cosine.
inline constexpr double sine_series[] = {-0.1666666666666663,    0.00833333333332184,    -0.00019841269829359216,
                                         2.7557313538812847e-06, -2.505073444293488e-08, 1.589543671761376e-10};
inline constexpr double cosine_series[] = {-0.5,
                                           0.041666666666666595,
                                           -0.0013888888888873056,
                                           2.4801587288851206e-05,
                                           -2.75573141791474e-07,
                                           2.087570082107165e-09,
                                           -1.1358535409957837e-11};

inline constexpr double largest_angle = 0x1p30; ///< large_angle.hpp reduces larger angles

/// sin(r + (k + more) pi/2), with k given as k + magic.
template <int more, int W> SKEIN_INLINE Pack<W> sine_of_quarters(const Pack<W>& r, const Pack<W>& counted) {
    using P = Pack<W>;
    const P z = r * r, squared = z * z;
    const P sine = fma(r * z, odd_and_even(z, squared, sine_series), r);
    const P cosine = fma(z, odd_and_even(z, squared, cosine_series), P(1.0));
    return alternating<more>(odd_or_even<more>(counted, cosine, sine), counted);
}

template <int W> [[gnu::noinline, gnu::cold]] Pack<W> sine_rarely(const Pack<W>& x, Pack<W> r, bool cosine) {
    for (int i = 0; i < W; ++i) {
        if (std::fabs(x[i]) <= largest_angle) continue;
        const Remainder of = large_remainder(std::fabs(x[i]));
        const Pack<1> rest(of.rest), counted(magic + of.quarters);
        const double sine = (cosine ? sine_of_quarters<1>(rest, counted) : sine_of_quarters<0>(rest, counted))[0];
        r.set(i, !cosine && x[i] < 0 ? -sine : sine);
    }
    return r;
}

/// sin(x + more pi/2) for |x| up to largest_angle. Cody and Waite's reduction by k pi/2 has pi/2 in three parts. The
/// first difference is exact: x and k times the first part are whole multiples of the last bit of that part.
template <int more, int W> SKEIN_INLINE Pack<W> sine_of_ordinary(const Pack<W>& x) {
    using P = Pack<W>;
    const P counted = fma(x, P(0.63661977236758134), P(magic)), k = counted - P(magic);
    P r = fnma(k, P(0x1.921fb54442d18p+0), x);
    r = fnma(k, P(0x1.1a62633145c07p-54), r);
    r = fnma(k, P(-0x1.f1976b7ed8fbcp-110), r);
    return sine_of_quarters<more>(r, counted);
}
template <int more, int W> SKEIN_INLINE Pack<W> sine_of_any(const Pack<W>& x) {
    const Pack<W> sine = sine_of_ordinary<more>(x);
    if (any(!(size_of(x) <= Pack<W>(largest_angle)))) [[unlikely]]
        return sine_rarely(x, sine, more != 0);
    return sine;
}

} // namespace detail

/// Sine within 1.5 units in the last place.
template <int W> SKEIN_INLINE Pack<W> sin(const Pack<W>& x) { return detail::sine_of_any<0>(x); }
template <int W> SKEIN_INLINE Pack<W> cos(const Pack<W>& x) { return detail::sine_of_any<1>(x); }

} // namespace skein
