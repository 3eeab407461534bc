// Packs as bits, for the signs and exponents of functions.
#pragma once

#include "skein/core/pack.hpp"

#include <bit>
#include <cstdint>

namespace skein::detail {

inline constexpr double magic = 6755399441055744.0; ///< 1.5 * 2^52: its addition and subtraction round to whole numbers

template <int W> SKEIN_INLINE Pack<W> to_nearest(const Pack<W>& x) { return (x + Pack<W>(magic)) - Pack<W>(magic); }

/// f of the bits of a and b, lane by lane.
template <int W, class F> SKEIN_INLINE Pack<W> of_bits(const Pack<W>& a, const Pack<W>& b, F f) {
    if constexpr (Wide<W>) {
        return {of_bits(a.low, b.low, f), of_bits(a.high, b.high, f)};
    } else {
        using Bits = typename Lanes<W>::Naturals;
        return Pack<W>(std::bit_cast<typename Pack<W>::Doubles>(f(std::bit_cast<Bits>(a.v), std::bit_cast<Bits>(b.v))));
    }
}

/// c[First] + c[First + 2] x^2 + c[First + 4] x^4 + ..., by Horner's rule.
template <int First, int W, int N> SKEIN_INLINE Pack<W> every_second(const Pack<W>& squared, const double (&c)[N]) {
    if constexpr (First + 2 >= N) return Pack<W>(c[First]);
    else return fma(every_second<First + 2>(squared, c), squared, Pack<W>(c[First]));
}
/// A polynomial as polynomial() gives it, with fewer products and longer latency, for known x^2 and series of packs.
template <int W, int N>
SKEIN_INLINE Pack<W> odd_and_even(const Pack<W>& x, const Pack<W>& squared, const double (&c)[N]) {
    return fma(every_second<1>(squared, c), x, every_second<0>(squared, c));
}

inline constexpr std::uint64_t sign_bit = std::uint64_t{1} << 63;

/// |x|, also for -0.
template <int W> SKEIN_INLINE Pack<W> size_of(const Pack<W>& x) {
    return of_bits(
        x, x, [](const auto& a, const auto&) __attribute__((always_inline)) { return a & ~sign_bit; });
}
/// x, or -x where `sign` is negative or -0.
template <int W> SKEIN_INLINE Pack<W> times_sign(const Pack<W>& x, const Pack<W>& sign) {
    return of_bits(
        x, sign, [](const auto& a, const auto& s) __attribute__((always_inline)) { return a ^ (s & sign_bit); });
}
/// a where k + more is odd, b elsewhere, with k in the last bits of k + magic.
template <int more, int W>
SKEIN_INLINE Pack<W> odd_or_even(const Pack<W>& counted, const Pack<W>& a, const Pack<W>& b) {
    if constexpr (Wide<W>) {
        return {odd_or_even<more>(counted.low, a.low, b.low), odd_or_even<more>(counted.high, a.high, b.high)};
    } else {
        const auto last = (std::bit_cast<typename Lanes<W>::Naturals>(counted.v) + more) & 1;
        if constexpr (W == 1) return select(Mask<W>{-static_cast<std::int64_t>(last)}, a, b);
        else return select(Mask<W>{last != 0}, a, b);
    }
}
/// x, or -x where k + more is 2 or 3 more than a multiple of 4.
template <int more, int W> SKEIN_INLINE Pack<W> alternating(const Pack<W>& x, const Pack<W>& counted) {
    return of_bits(
        x, counted,
        [](const auto& a, const auto& k) __attribute__((always_inline)) { return a ^ ((k + more) << 62 & sign_bit); });
}
/// x 2^k, with k given as k + magic; x and the result are normal.
template <int W> SKEIN_INLINE Pack<W> doubled(const Pack<W>& x, const Pack<W>& counted) {
    return of_bits(
        x, counted, [](const auto& a, const auto& k) __attribute__((always_inline)) { return a + (k << 52); });
}

/// x 2^-k, with k given as k + magic; x and the result are normal.
template <int W> SKEIN_INLINE Pack<W> halved(const Pack<W>& x, const Pack<W>& counted) {
    return of_bits(
        x, counted, [](const auto& a, const auto& k) __attribute__((always_inline)) { return a - (k << 52); });
}

} // namespace skein::detail
