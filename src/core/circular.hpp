// Sine and cosine over packs. All widths give the same bits: what a lane gets depends on its own number alone.
#pragma once

#include "skein/core/pack.hpp"

namespace skein {

namespace detail {

// Taylor series on |r| <= pi/4: (sin(r) - r)/r^3 and (cos(r) - 1 + r^2/2)/r^4 in r^2. First omitted terms 8e-20 and 5e-21.
inline constexpr double sine_series[] = {-1.0 / 6,        1.0 / 120,        -1.0 / 5040,          1.0 / 362880,
                                         -1.0 / 39916800, 1.0 / 6227020800, -1.0 / 1307674368000, 1.0 / 355687428096000};
inline constexpr double cosine_series[] = {1.0 / 24,        -1.0 / 720,         1.0 / 40320,          -1.0 / 3628800,
                                           1.0 / 479001600, -1.0 / 87178291200, 1.0 / 20922789888000, -1.0 / 6402373705728000};
/// Beyond it the C library, which knows more digits of pi.
inline constexpr double largest_angle = 1e5;

inline constexpr double magic = 6755399441055744.0; ///< 1.5 * 2^52: adding and subtracting it rounds to whole numbers

template <int W> SKEIN_INLINE Pack<W> to_nearest(const Pack<W>& x) { return (x + Pack<W>(magic)) - Pack<W>(magic); }
/// Of k quarter turns the sine: of r in even ones +-sine, in odd ones +-cosine. `counted`: k + magic, whose last bits are k's.
template <int quarters, int W>
SKEIN_INLINE Pack<W> in_its_quarter(const Pack<W>& counted, const Pack<W>& sine, const Pack<W>& cosine) {
    if constexpr (Wide<W>) {
        return {in_its_quarter<quarters>(counted.low, sine.low, cosine.low),
                in_its_quarter<quarters>(counted.high, sine.high, cosine.high)};
    } else {
        using Bits = typename Lanes<W>::Naturals;
        using Doubles = typename Pack<W>::Doubles;
        const Bits k = std::bit_cast<Bits>(counted.v) + quarters, sign = (k >> 1) << 63;
        Mask<W> odd;
        if constexpr (W == 1) odd = {-static_cast<std::int64_t>(k & 1)};
        else odd = {(k & 1) != 0};
        return Pack<W>(std::bit_cast<Doubles>(std::bit_cast<Bits>(select(odd, cosine, sine).v) ^ sign));
    }
}

/// sin(x + quarters pi/2) for |x| up to largest_angle. Cody and Waite's reduction with pi/2 in three parts: the first product is
/// exact, as everything is a whole multiple of the last bit of pi/2.
template <int quarters, int W> SKEIN_INLINE Pack<W> sine_of_quarters(const Pack<W>& x) {
    using P = Pack<W>;
    const P counted = x * P(0.63661977236758134) + P(magic), k = counted - P(magic);
    P r = fnma(k, P(0x1.921fb54442d18p+0), x);
    r = fnma(k, P(0x1.1a62633145c07p-54), r);
    r = fnma(k, P(-0x1.f1976b7ed8fbcp-110), r);
    const P z = r * r, half = P(0.5) * z, most = P(1.0) - half;
    const P sine = fma(r * z, polynomial(z, sine_series), r);
    const P cosine = most + (((P(1.0) - most) - half) + (z * z) * polynomial(z, cosine_series));
    return in_its_quarter<quarters>(counted, sine, cosine);
}

template <int W> SKEIN_INLINE bool any_large(const Pack<W>& x) {
    return any(!((x <= Pack<W>(largest_angle)) & (x >= Pack<W>(-largest_angle))));
}
template <int W> [[gnu::noinline, gnu::cold]] void sine_rarely(const Pack<W>& x, Pack<W>& r, bool cosine) {
    for (int i = 0; i < W; ++i)
        if (!(std::fabs(x[i]) <= largest_angle)) r.set(i, cosine ? std::cos(x[i]) : std::sin(x[i]));
}

} // namespace detail

/// Within 1.5 units in the last place for |x| up to 1e5, beyond as the C library.
template <int W> SKEIN_INLINE Pack<W> sin(const Pack<W>& x) {
    Pack<W> r = detail::sine_of_quarters<0>(x);
    if (detail::any_large(x)) [[unlikely]]
        detail::sine_rarely(x, r, false);
    return r;
}
template <int W> SKEIN_INLINE Pack<W> cos(const Pack<W>& x) {
    Pack<W> r = detail::sine_of_quarters<1>(x);
    if (detail::any_large(x)) [[unlikely]]
        detail::sine_rarely(x, r, true);
    return r;
}

} // namespace skein
