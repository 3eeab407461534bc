// Pack<W>: W doubles side by side, one rod per lane. Physics is written once over Pack<W>; W = 1 is the oracle of every
// other width. All widths give the same bits: the build switches implicit contraction off (-ffp-contract=off) and every
// fused multiply-add is spelled fma().
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#if defined(__AVX2__) || defined(__AVX512F__)
#include <immintrin.h>
#endif

namespace skein {

namespace detail {
template <int W> struct Lanes {
    typedef double Doubles __attribute__((vector_size(8 * W)));
    typedef std::int64_t Integers __attribute__((vector_size(8 * W)));
};
} // namespace detail

/// Result of a comparison: all bits set in the lanes where it holds.
template <int W> struct Mask {
    typename detail::Lanes<W>::Integers bits;

    bool operator[](int lane) const { return bits[lane] != 0; }
    friend Mask operator&(Mask a, Mask b) { return {a.bits & b.bits}; }
    friend Mask operator|(Mask a, Mask b) { return {a.bits | b.bits}; }
    friend Mask operator!(Mask a) { return {~a.bits}; }
};

template <int W> inline bool any(Mask<W> m) {
#if defined(__AVX512DQ__)
    if constexpr (W == 8) return _mm512_movepi64_mask(std::bit_cast<__m512i>(m.bits)) != 0;
#endif
    bool found = false;
    for (int lane = 0; lane < W; ++lane) found |= m.bits[lane] != 0;
    return found;
}

template <int W> struct Pack {
    static constexpr int width = W;
    using Doubles = typename detail::Lanes<W>::Doubles;
    Doubles v;

    Pack() = default;
    Pack(Doubles lanes) : v(lanes) {}
    Pack(double value) : v(Doubles{} + value) {}

    double operator[](int lane) const { return v[lane]; }
    void set(int lane, double value) { v[lane] = value; }

    Pack& operator+=(Pack b) { v += b.v; return *this; }
    Pack& operator-=(Pack b) { v -= b.v; return *this; }
    Pack& operator*=(Pack b) { v *= b.v; return *this; }

    friend Pack operator+(Pack a, Pack b) { return a.v + b.v; }
    friend Pack operator-(Pack a, Pack b) { return a.v - b.v; }
    friend Pack operator*(Pack a, Pack b) { return a.v * b.v; }
    friend Pack operator/(Pack a, Pack b) { return a.v / b.v; }
    friend Pack operator-(Pack a) { return -a.v; }
    friend Mask<W> operator<(Pack a, Pack b) { return {a.v < b.v}; }
    friend Mask<W> operator>(Pack a, Pack b) { return {a.v > b.v}; }
    friend Mask<W> operator<=(Pack a, Pack b) { return {a.v <= b.v}; }
    friend Mask<W> operator>=(Pack a, Pack b) { return {a.v >= b.v}; }
};

/// a b + c, rounded once.
template <int W> inline Pack<W> fma(Pack<W> a, Pack<W> b, Pack<W> c) {
#if defined(__AVX512F__)
    if constexpr (W == 8) return Pack<W>(std::bit_cast<typename Pack<W>::Doubles>(
        _mm512_fmadd_pd(std::bit_cast<__m512d>(a.v), std::bit_cast<__m512d>(b.v), std::bit_cast<__m512d>(c.v))));
#endif
#if defined(__FMA__)
    if constexpr (W == 4) return Pack<W>(std::bit_cast<typename Pack<W>::Doubles>(
        _mm256_fmadd_pd(std::bit_cast<__m256d>(a.v), std::bit_cast<__m256d>(b.v), std::bit_cast<__m256d>(c.v))));
    if constexpr (W == 2) return Pack<W>(std::bit_cast<typename Pack<W>::Doubles>(
        _mm_fmadd_pd(std::bit_cast<__m128d>(a.v), std::bit_cast<__m128d>(b.v), std::bit_cast<__m128d>(c.v))));
#endif
    Pack<W> r;
    for (int lane = 0; lane < W; ++lane) r.v[lane] = __builtin_fma(a.v[lane], b.v[lane], c.v[lane]);
    return r;
}
/// c - a b, rounded once.
template <int W> inline Pack<W> fnma(Pack<W> a, Pack<W> b, Pack<W> c) { return fma(-a, b, c); }

template <int W> inline Pack<W> sqrt(Pack<W> a) {
#if defined(__AVX512F__)
    if constexpr (W == 8) return Pack<W>(std::bit_cast<typename Pack<W>::Doubles>(_mm512_maskz_sqrt_pd(0xff, std::bit_cast<__m512d>(a.v))));
#endif
#if defined(__AVX__)
    if constexpr (W == 4) return Pack<W>(std::bit_cast<typename Pack<W>::Doubles>(_mm256_sqrt_pd(std::bit_cast<__m256d>(a.v))));
#endif
    Pack<W> r;
    for (int lane = 0; lane < W; ++lane) r.v[lane] = __builtin_sqrt(a.v[lane]);
    return r;
}

/// a where the mask holds, b elsewhere.
template <int W> inline Pack<W> select(Mask<W> m, Pack<W> a, Pack<W> b) { return Pack<W>(m.bits ? a.v : b.v); }
template <int W> inline Pack<W> abs(Pack<W> a) { return select(a < Pack<W>(0.0), -a, a); }
template <int W> inline Pack<W> max(Pack<W> a, Pack<W> b) { return select(a < b, b, a); }
template <int W> inline Pack<W> min(Pack<W> a, Pack<W> b) { return select(b < a, b, a); }

/// 2^k for whole-numbered k in [-1022, 1023].
template <int W> inline Pack<W> power_of_two(Pack<W> k) {
    const auto exponent = __builtin_convertvector(k.v, typename detail::Lanes<W>::Integers) + 1023;
    return Pack<W>(std::bit_cast<typename Pack<W>::Doubles>(exponent << 52));
}

/// c[0] + x (c[1] + x (c[2] + ...)), Horner with fused multiply-adds.
template <int W, int N> inline Pack<W> polynomial(Pack<W> x, const double (&c)[N]) {
    Pack<W> y(c[N - 1]);
    for (int i = N - 2; i >= 0; --i) y = fma(y, x, Pack<W>(c[i]));
    return y;
}

} // namespace skein
