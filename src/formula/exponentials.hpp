// Exponential, logarithm, hyperbolic tangent and powers over packs, for any number. core/exponential.hpp and
// core/logarithm.hpp serve the narrower ranges of the kernels.
#pragma once

#include "formula/lane_bits.hpp"

#include <cmath>
#include <limits>

namespace skein {

namespace detail {

// (exp(r) - 1 - r)/r^2 on |r| <= ln(2)/2, minimax in the exponential: relative error 1e-17.
inline constexpr double exponential_series[] = {0.5000000000000011,    0.16666666666666413,    0.041666666666530155,
                                                0.008333333333494463,  0.001388888894363038,   0.00019841269506575744,
                                                2.480149309863533e-05, 2.7557586375678646e-06, 2.763024847316803e-07,
                                                2.5000061183251388e-08};
// (ln(m) - 2 s)/s^3 in s^2, s = (m - 1)/(m + 1), on sqrt(1/2) <= m <= sqrt(2), minimax in the logarithm: relative error
// 1e-18.
inline constexpr double logarithm_series[] = {0.6666666666666734,  0.3999999999941704,  0.28571428741895166,
                                              0.22222198621281986, 0.18183561927429714, 0.15314109750530142,
                                              0.147953762384299};
// (ln(m)/(2 s) - 1 - s^2/3)/s^4 in s^2 on the same range: 1e-20.
inline constexpr double logarithm_tail[] = {0.1999999999999999,   0.1428571428572255,  0.11111111108769525,
                                            0.09090909434998218,  0.07692278446372104, 0.06668158290674332,
                                            0.058374177645743514, 0.05994435631695045};

inline constexpr double halvings = 1.4426950408889634; ///< 1/ln(2)
inline constexpr double ln2 = 0x1.62e42fefa39efp-1, ln2_low = 0x1.abc9e3b39803fp-56;
/// ln(2) in two parts: whole multiples of the first, up to 2^11, are exact.
inline constexpr double ln2_short = 0x1.62e42fefa38p-1, ln2_rest = 0x1.ef35793c7673p-45;
inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double smallest_normal = std::numeric_limits<double>::min();
inline constexpr double largest_exponent = 708; ///< exponentials are normal numbers between its negative and it

template <int W> struct Twofold { Pack<W> high, low; };

/// exp(r) for |r| <= ln(2)/2.
template <int W> SKEIN_INLINE Pack<W> exponential_of_rest(const Pack<W>& r) {
    const Pack<W> squared = r * r;
    return Pack<W>(1.0) + fma(squared, odd_and_even(r, squared, exponential_series), r);
}

/// exp(x + low) where it may be infinite, 0, or of few bits: 2^k in two factors.
template <int W> [[gnu::noinline]] Pack<W> exponential_rarely(const Pack<W>& x, const Pack<W>& low, Pack<W> result) {
    using P = Pack<W>;
    const P near = max(min(x, P(710.0)), P(-746.0)); // NaN stays NaN
    const P k = to_nearest(near * P(halvings)), half = to_nearest(P(0.5) * k), others = k - half;
    const P r = fnma(k, P(ln2), near) + fnma(k, P(ln2_low), low);
    const P all = (exponential_of_rest(r) * doubled(P(1.0), half + P(magic))) * doubled(P(1.0), others + P(magic));
    const Mask<W> far = !(size_of(x) <= P(largest_exponent));
    const P clear = select(x > P(710.0), P(infinity), select(x < P(-746.0), P(0.0), all));
    return select(far, clear, result);
}

/// exp(x), or exp(x + low...), for |x| up to largest_exponent.
template <int W, class... Low> SKEIN_INLINE Pack<W> exponential_of_ordinary(const Pack<W>& x, const Low&... low) {
    using P = Pack<W>;
    const P counted = fma(x, P(-halvings), P(magic)), k = counted - P(magic), first = fma(k, P(ln2), x);
    if constexpr (sizeof...(Low) == 0) return halved(exponential_of_rest(fma(k, P(ln2_low), first)), counted);
    else return halved(exponential_of_rest(first + fma(k, P(ln2_low), low...)), counted);
}
template <int W, class... Low> SKEIN_INLINE Pack<W> exponential_of(const Pack<W>& x, const Low&... low) {
    const Pack<W> result = exponential_of_ordinary(x, low...);
    if (any(!(size_of(x) <= Pack<W>(largest_exponent)))) [[unlikely]] {
        if constexpr (sizeof...(Low) == 0) return exponential_rarely(x, Pack<W>(0.0), result);
        else return exponential_rarely(x, low..., result);
    }
    return result;
}

/// ln(m) + k ln(2).
template <int W> SKEIN_INLINE Pack<W> logarithm_of(const Split<W>& x) {
    using P = Pack<W>;
    const auto& [m, k] = x;
    // 2 s = f - f^2/2 + s f^2/2, so that only what is small beside f is rounded.
    const P f = m - P(1.0), s = f / (m + P(1.0)), z = s * s, half = P(0.5) * f * f;
    const P small = fma(s, fma(z, polynomial(z, logarithm_series), half), k * P(ln2_rest));
    return fma(k, P(ln2_short), f - (half - small));
}
template <int W> [[gnu::noinline]] Pack<W> logarithm_rarely(const Pack<W>& x, Pack<W> result) {
    using P = Pack<W>;
    Split<W> scaled = split(x * P(0x1p54));
    scaled.k -= P(54.0);
    const P tiny =
        select(x > P(0.0), logarithm_of(scaled), select(x < P(0.0), P(std::numeric_limits<double>::quiet_NaN()), x));
    const P low = select((x <= P(0.0)) & (x >= P(0.0)), P(-infinity), tiny);
    return select(x < P(smallest_normal), low, select(x < P(infinity), result, x));
}

/// ln(m) + k ln(2) to 65 bits.
template <int W> SKEIN_INLINE Twofold<W> long_logarithm_of(const Split<W>& x) {
    using P = Pack<W>;
    const auto& [m, k] = x;
    const P f = m - P(1.0), sum = m + P(1.0), sum_low = m - (sum - P(1.0)), inverse = P(1.0) / sum;
    const P s = f * inverse, s_low = fnma(s, sum_low, fnma(s, sum, f)) * inverse;
    const P z = s * s, z_low = fma(s + s, s_low, fms(s, s, z));
    const P tail = z * polynomial(z, logarithm_tail), c = P(0x1.5555555555555p-2) + tail;
    const P c_low = ((P(0x1.5555555555555p-2) - c) + tail) + P(0x1.5555555555555p-56);
    const P u = z * c, u_low = fma(z, c_low, fma(z_low, c, fms(z, c, u)));
    const P v = s * u, v_low = fma(s, u_low, fma(s_low, u, fms(s, u, v)));
    const P of_m = s + v, of_m_low = ((s - of_m) + v) + (s_low + v_low);
    const P whole = k * P(ln2_short), twice = of_m + of_m, all = whole + twice;
    return {all, (twice - (all - whole)) + fma(k, P(ln2_rest), of_m_low + of_m_low)};
}
template <int W> SKEIN_INLINE Pack<W> power_of(const Split<W>& a, const Pack<W>& b) {
    const Twofold<W> log = long_logarithm_of(a);
    const Pack<W> product = b * log.high;
    return exponential_of(product, fma(b, log.low, fms(b, log.high, product)));
}

/// a^b where a is not positive, finite and normal, or b not finite: the result is that of C.
[[gnu::noinline]] inline double power_rarely(double a, double b) {
    if (b == 0 || a == 1) return 1;
    if (std::isnan(a) || std::isnan(b)) return a + b;
    const double size = std::fabs(a);
    if (std::fabs(b) == infinity) return size == 1 ? 1 : (size > 1) == (b > 0) ? infinity : 0;
    constexpr double all_even = 9007199254740992; // 2^53: all larger numbers are even
    const bool large = std::fabs(b) >= all_even;
    const auto n = large ? std::int64_t{0} : static_cast<std::int64_t>(b);
    const bool whole = large || static_cast<double>(n) == b, negative = std::signbit(a) && n % 2 != 0 && whole;
    double r;
    if (size == 0 || size == infinity) {
        r = (size == 0) == (b > 0) ? 0 : infinity;
    } else {
        if (a < 0 && !whole) return std::numeric_limits<double>::quiet_NaN();
        const bool tiny = size < smallest_normal;
        Split<1> parts = split(Pack<1>(tiny ? size * 0x1p54 : size));
        if (tiny) parts.k -= Pack<1>(54.0);
        r = power_of(parts, Pack<1>(b))[0];
    }
    return negative ? -r : r;
}

// expm1(r) = r + r^2 times a series, for the remainder of 2 |x| in two parts. 2^-k - 1 and 2^-k + 1 carry the rounding
// errors of both sums.
template <int W> SKEIN_INLINE Pack<W> hyperbolic_tangent_of_size(const Pack<W>& size) {
    using P = Pack<W>;
    const P x = min(size + size, P(88.0)); // terms below 2^-60 of 1 do not matter
    const P counted = fma(x, P(halvings), P(magic)), k = counted - P(magic), first = fnma(k, P(ln2), x);
    const P r = fnma(k, P(ln2_low), first), r_low = fnma(k, P(ln2_low), first - r);
    const P squared = r * r, more = squared * odd_and_even(r, squared, exponential_series), e = r + more,
            e_low = ((r - e) + more) + fma(r_low, e, r_low);
    const P inverse_power = doubled(P(1.0), P(magic) - k);
    const P less = P(1.0) - inverse_power, above = P(1.0) + inverse_power;
    const P less_low = (P(1.0) - less) - inverse_power, above_low = inverse_power - (above - P(1.0));
    const P top = less + e, top_low = (e - (top - less)) + (e_low + less_low), bottom = above + e,
            bottom_low = (e - (bottom - above)) + (e_low + above_low);
    const P inverse = P(1.0) / bottom, t = top * inverse;
    return fma(fnma(t, bottom, top) + fnma(t, bottom_low, top_low), inverse, t);
}

} // namespace detail

// Errors in units in the last place: exponential 1.1, logarithm 0.9, hyperbolic tangent and powers 1.15.

template <int W> SKEIN_INLINE Pack<W> exponential(const Pack<W>& x) { return detail::exponential_of(x); }

template <int W> SKEIN_INLINE Pack<W> logarithm(const Pack<W>& x) {
    using P = Pack<W>;
    P r = detail::logarithm_of(split(x));
    if (any(!((x >= P(detail::smallest_normal)) & (x < P(detail::infinity))))) [[unlikely]]
        r = detail::logarithm_rarely(x, r);
    return r;
}

template <int W> SKEIN_INLINE Pack<W> hyperbolic_tangent(const Pack<W>& x) {
    return detail::times_sign(detail::hyperbolic_tangent_of_size(detail::size_of(x)), x);
}

/// a^b, for any b.
template <int W> SKEIN_INLINE Pack<W> power(const Pack<W>& a, const Pack<W>& b) {
    using P = Pack<W>;
    const Mask<W> good =
        (a >= P(detail::smallest_normal)) & (a < P(detail::infinity)) & (detail::size_of(b) < P(detail::infinity));
    P r = detail::power_of(split(select(good, a, P(1.0))), select(good, b, P(1.0)));
    if (any(!good)) [[unlikely]]
        for (int i = 0; i < W; ++i)
            if (!good[i]) r.set(i, detail::power_rarely(a[i], b[i]));
    return r;
}

} // namespace skein
