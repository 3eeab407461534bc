// Pack<W>: W doubles side by side, one rod per lane. Physics is written once over Pack<W>; W = 1 is the reference for
// every other width. All widths give the same bits: the build switches implicit contraction off (-ffp-contract=off) and
// every fused multiply-add is spelled fma().
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>
#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace skein {

/// Attribute of the building blocks of kernels. GCC 12 would keep some of them out of line and pass packs through
/// memory, which costs 8 % of the elastic pass and 15 % of the kick.
#define SKEIN_INLINE [[gnu::always_inline]] inline

/// Doubles of one register at the level for which this source is compiled. Wider packs consist of two halves: GCC 12
/// would split wide vectors through memory, at five times the cost.
#if defined(__AVX512F__)
inline constexpr int native_lanes = 8;
#elif defined(__AVX__)
inline constexpr int native_lanes = 4;
#else
inline constexpr int native_lanes = 2;
#endif

/// Width of a number with its slopes (core/dual_pack.hpp): one lane.
inline constexpr int dual = 1 << 10;
/// Rods side by side in a pack.
template <int W> inline constexpr int lanes_of = W;
template <> inline constexpr int lanes_of<dual> = 1;

template <int W>
concept Wide = (W > native_lanes && W != dual);

namespace detail {
template <int W> struct Lanes {
    typedef double Doubles __attribute__((vector_size(8 * W)));
    typedef std::int64_t Integers __attribute__((vector_size(8 * W)));
    typedef std::uint64_t Naturals __attribute__((vector_size(8 * W)));
};
template <> struct Lanes<1> { // plain numbers: GCC's one-lane vectors are three times slower
    using Doubles = double;
    using Integers = std::int64_t;
    using Naturals = std::uint64_t;
};
} // namespace detail

/// Result of a comparison: all bits are set in the lanes where it holds.
template <int W> struct Mask {
    typename detail::Lanes<W>::Integers bits;

    bool operator[]([[maybe_unused]] int lane) const {
        if constexpr (W == 1) return bits != 0;
        else return bits[lane] != 0;
    }
    SKEIN_INLINE friend Mask operator&(Mask a, Mask b) { return {a.bits & b.bits}; }
    SKEIN_INLINE friend Mask operator|(Mask a, Mask b) { return {a.bits | b.bits}; }
    SKEIN_INLINE friend Mask operator!(Mask a) { return {~a.bits}; }
};

template <int W>
requires Wide<W>
struct alignas(8 * W) Mask<W> {
    Mask<W / 2> low, high;

    bool operator[](int lane) const { return lane < W / 2 ? low[lane] : high[lane - W / 2]; }
    SKEIN_INLINE friend Mask operator&(const Mask& a, const Mask& b) { return {a.low & b.low, a.high & b.high}; }
    SKEIN_INLINE friend Mask operator|(const Mask& a, const Mask& b) { return {a.low | b.low, a.high | b.high}; }
    SKEIN_INLINE friend Mask operator!(const Mask& a) { return {!a.low, !a.high}; }
};

/// Bit i is set where lane i holds.
template <int W> SKEIN_INLINE unsigned bits_of(const Mask<W>& m) {
    if constexpr (Wide<W>) {
        return bits_of(m.low) | bits_of(m.high) << W / 2;
    } else {
#if defined(__AVX512DQ__)
        if constexpr (W == 8) return _mm512_movepi64_mask(std::bit_cast<__m512i>(m.bits));
#endif
#if defined(__AVX__)
        if constexpr (W == 4) return static_cast<unsigned>(_mm256_movemask_pd(std::bit_cast<__m256d>(m.bits)));
#endif
        unsigned bits = 0;
        for (int lane = 0; lane < W; ++lane) bits |= static_cast<unsigned>(m[lane]) << lane;
        return bits;
    }
}
template <int W> SKEIN_INLINE bool any(const Mask<W>& m) { return bits_of(m) != 0; }

template <int W> struct Pack {
    static constexpr int width = W;
    using Doubles = typename detail::Lanes<W>::Doubles;
    Doubles v;

    Pack() = default;
    SKEIN_INLINE Pack(Doubles lanes) requires(W > 1) : v(lanes) {}
    /// Value in every lane. (Less 0 is the value itself; plus 0 is not, for -0, and costs an addition.)
    SKEIN_INLINE Pack(double value) : v(value - Doubles{}) {}

    double operator[]([[maybe_unused]] int lane) const {
        if constexpr (W == 1) return v;
        else return v[lane];
    }
    void set([[maybe_unused]] int lane, double value) {
        if constexpr (W == 1) v = value;
        else v[lane] = value;
    }

    SKEIN_INLINE Pack& operator+=(const Pack& b) { return *this = *this + b; }
    SKEIN_INLINE Pack& operator-=(const Pack& b) { return *this = *this - b; }
    SKEIN_INLINE Pack& operator*=(const Pack& b) { return *this = *this * b; }

    SKEIN_INLINE friend Pack operator+(Pack a, Pack b) { return a.v + b.v; }
    SKEIN_INLINE friend Pack operator-(Pack a, Pack b) { return a.v - b.v; }
    SKEIN_INLINE friend Pack operator*(Pack a, Pack b) { return a.v * b.v; }
    SKEIN_INLINE friend Pack operator/(Pack a, Pack b) { return a.v / b.v; }
    SKEIN_INLINE friend Pack operator-(Pack a) { return -a.v; }
    SKEIN_INLINE friend Mask<W> operator<(Pack a, Pack b) { return mask(a.v < b.v); }
    SKEIN_INLINE friend Mask<W> operator>(Pack a, Pack b) { return mask(a.v > b.v); }
    SKEIN_INLINE friend Mask<W> operator<=(Pack a, Pack b) { return mask(a.v <= b.v); }
    SKEIN_INLINE friend Mask<W> operator>=(Pack a, Pack b) { return mask(a.v >= b.v); }

private:
    template <class C> SKEIN_INLINE static Mask<W> mask(C comparison) {
        if constexpr (W == 1) return {-static_cast<std::int64_t>(comparison)};
        else return {comparison};
    }
};

template <int W>
requires Wide<W>
struct alignas(8 * W) Pack<W> {
    static constexpr int width = W;
    using Half = Pack<W / 2>;
    Half low, high;

    Pack() = default;
    SKEIN_INLINE Pack(Half l, Half h) : low(l), high(h) {}
    SKEIN_INLINE Pack(double value) : low(value), high(value) {}

    double operator[](int lane) const { return lane < W / 2 ? low[lane] : high[lane - W / 2]; }
    void set(int lane, double value) { lane < W / 2 ? low.set(lane, value) : high.set(lane - W / 2, value); }
    SKEIN_INLINE Pack& operator+=(const Pack& b) { return *this = *this + b; }
    SKEIN_INLINE Pack& operator-=(const Pack& b) { return *this = *this - b; }
    SKEIN_INLINE Pack& operator*=(const Pack& b) { return *this = *this * b; }

    SKEIN_INLINE friend Pack operator+(const Pack& a, const Pack& b) { return {a.low + b.low, a.high + b.high}; }
    SKEIN_INLINE friend Pack operator-(const Pack& a, const Pack& b) { return {a.low - b.low, a.high - b.high}; }
    SKEIN_INLINE friend Pack operator*(const Pack& a, const Pack& b) { return {a.low * b.low, a.high * b.high}; }
    SKEIN_INLINE friend Pack operator/(const Pack& a, const Pack& b) { return {a.low / b.low, a.high / b.high}; }
    SKEIN_INLINE friend Pack operator-(const Pack& a) { return {-a.low, -a.high}; }
    SKEIN_INLINE friend Mask<W> operator<(const Pack& a, const Pack& b) { return {a.low < b.low, a.high < b.high}; }
    SKEIN_INLINE friend Mask<W> operator>(const Pack& a, const Pack& b) { return {a.low > b.low, a.high > b.high}; }
    SKEIN_INLINE friend Mask<W> operator<=(const Pack& a, const Pack& b) { return {a.low <= b.low, a.high <= b.high}; }
    SKEIN_INLINE friend Mask<W> operator>=(const Pack& a, const Pack& b) { return {a.low >= b.low, a.high >= b.high}; }
};
namespace detail {
#if defined(__x86_64__) && !defined(__FMA__)
using TwoDoubles = double __attribute__((vector_size(16)));
[[gnu::noinline, gnu::cold]] inline TwoDoubles fma_by_library(TwoDoubles a, TwoDoubles b, TwoDoubles c) {
    return TwoDoubles{__builtin_fma(a[0], b[0], c[0]), __builtin_fma(a[1], b[1], c[1])};
}
/// a b + c of two lanes, rounded once, at a level without an instruction for it: by the instruction where the
/// processor has it all the same. Volatile: the instruction may not move above the question.
SKEIN_INLINE TwoDoubles fma_of_two(TwoDoubles a, TwoDoubles b, TwoDoubles c) {
    if (!__builtin_cpu_supports("fma")) [[unlikely]]
        return fma_by_library(a, b, c);
    asm volatile("{vfmadd213pd %2, %1, %0|vfmadd213pd %0, %1, %2}" : "+x"(a) : "x"(b), "x"(c));
    return a;
}
#endif
/// The same of one.
SKEIN_INLINE double fma_of_one(double a, double b, double c) {
#if defined(__x86_64__) && !defined(__FMA__)
    if (__builtin_cpu_supports("fma")) [[likely]] {
        asm volatile("{vfmadd213sd %2, %1, %0|vfmadd213sd %0, %1, %2}" : "+x"(a) : "x"(b), "x"(c));
        return a;
    }
#endif
    return __builtin_fma(a, b, c);
}
} // namespace detail

/// a b + c, rounded once.
template <int W> SKEIN_INLINE Pack<W> fma(const Pack<W>& a, const Pack<W>& b, const Pack<W>& c) {
    if constexpr (Wide<W>) {
        return {fma(a.low, b.low, c.low), fma(a.high, b.high, c.high)};
    } else {
        using Doubles [[maybe_unused]] = typename Pack<W>::Doubles;
#if defined(__AVX512F__)
        if constexpr (W == 8)
            return Pack<W>(std::bit_cast<Doubles>(_mm512_fmadd_pd(
                std::bit_cast<__m512d>(a.v), std::bit_cast<__m512d>(b.v), std::bit_cast<__m512d>(c.v))));
#endif
#if defined(__FMA__)
        if constexpr (W == 4)
            return Pack<W>(std::bit_cast<Doubles>(_mm256_fmadd_pd(
                std::bit_cast<__m256d>(a.v), std::bit_cast<__m256d>(b.v), std::bit_cast<__m256d>(c.v))));
        if constexpr (W == 2)
            return Pack<W>(std::bit_cast<Doubles>(
                _mm_fmadd_pd(std::bit_cast<__m128d>(a.v), std::bit_cast<__m128d>(b.v), std::bit_cast<__m128d>(c.v))));
#endif
#if defined(__x86_64__) && !defined(__FMA__)
        if constexpr (W == 2) return Pack<W>(detail::fma_of_two(a.v, b.v, c.v));
#endif
        Pack<W> r;
        for (int lane = 0; lane < W; ++lane) r.set(lane, detail::fma_of_one(a[lane], b[lane], c[lane]));
        return r;
    }
}
/// a b - c, rounded once. (GCC would negate c first where it needs c as well.)
template <int W> SKEIN_INLINE Pack<W> fms(const Pack<W>& a, const Pack<W>& b, const Pack<W>& c) {
#if defined(__AVX512F__)
    if constexpr (W == 8)
        return Pack<W>(std::bit_cast<typename Pack<W>::Doubles>(
            _mm512_fmsub_pd(std::bit_cast<__m512d>(a.v), std::bit_cast<__m512d>(b.v), std::bit_cast<__m512d>(c.v))));
#endif
    return fma(a, b, -c);
}
/// c - a b, rounded once.
template <int W> SKEIN_INLINE Pack<W> fnma(const Pack<W>& a, const Pack<W>& b, const Pack<W>& c) {
    return fma(-a, b, c);
}

template <int W> SKEIN_INLINE Pack<W> sqrt(const Pack<W>& a) {
    if constexpr (Wide<W>) {
        return {sqrt(a.low), sqrt(a.high)};
    } else {
        using Doubles [[maybe_unused]] = typename Pack<W>::Doubles;
#if defined(__AVX512F__)
        if constexpr (W == 8)
            return Pack<W>(std::bit_cast<Doubles>(_mm512_maskz_sqrt_pd(0xff, std::bit_cast<__m512d>(a.v))));
#endif
#if defined(__AVX__)
        if constexpr (W == 4) return Pack<W>(std::bit_cast<Doubles>(_mm256_sqrt_pd(std::bit_cast<__m256d>(a.v))));
#endif
        Pack<W> r;
        for (int lane = 0; lane < W; ++lane) r.set(lane, __builtin_sqrt(a[lane]));
        return r;
    }
}

/// a where the mask holds, b elsewhere.
template <int W> SKEIN_INLINE Pack<W> select(const Mask<W>& m, const Pack<W>& a, const Pack<W>& b) {
    if constexpr (Wide<W>) return {select(m.low, a.low, b.low), select(m.high, a.high, b.high)};
    else return Pack<W>(m.bits ? a.v : b.v);
}
template <int W> SKEIN_INLINE Pack<W> abs(const Pack<W>& a) { return select(a < Pack<W>(0.0), -a, a); }
template <int W> SKEIN_INLINE Pack<W> max(const Pack<W>& a, const Pack<W>& b) {
#if defined(__AVX512F__) // one instruction, with the same result even where one operand is NaN
    if constexpr (W == 8)
        return Pack<W>(std::bit_cast<typename Pack<W>::Doubles>(
            _mm512_maskz_max_pd(0xff, std::bit_cast<__m512d>(b.v), std::bit_cast<__m512d>(a.v))));
#endif
    return select(a < b, b, a);
}
template <int W> SKEIN_INLINE Pack<W> min(const Pack<W>& a, const Pack<W>& b) { return select(b < a, b, a); }

namespace detail {
/// Lane i takes lane (i + Shift) mod W.
template <int Shift, int W> SKEIN_INLINE Pack<W> rotated(const Pack<W>& a) {
    if constexpr (W == 1) {
        return a;
    } else if constexpr (Wide<W>) {
        Pack<W> r;
        for (int lane = 0; lane < W; ++lane) r.set(lane, a[(lane + Shift) % W]);
        return r;
    } else {
        const auto shuffled = [&]<int... I>(std::integer_sequence<int, I...>) {
            return Pack<W>(__builtin_shufflevector(a.v, a.v, ((I + Shift) % W)...));
        };
        return shuffled(std::make_integer_sequence<int, W>{});
    }
}
} // namespace detail

/// Value of the neighbouring lane; the ends go round.
template <int W> SKEIN_INLINE Pack<W> from_lane_before(const Pack<W>& a) { return detail::rotated<W - 1>(a); }
template <int W> SKEIN_INLINE Pack<W> from_lane_after(const Pack<W>& a) { return detail::rotated<1>(a); }

/// 2^k for whole-numbered k in [-1022, 1023].
template <int W> SKEIN_INLINE Pack<W> power_of_two(const Pack<W>& k) {
    if constexpr (Wide<W>) {
        return {power_of_two(k.low), power_of_two(k.high)};
    } else {
        using Integers = typename detail::Lanes<W>::Integers;
        Integers exponent;
        if constexpr (W == 1) exponent = static_cast<std::int64_t>(k.v) + 1023;
        else exponent = __builtin_convertvector(k.v, Integers) + 1023;
        return Pack<W>(std::bit_cast<typename Pack<W>::Doubles>(exponent << 52));
    }
}

/// Decomposition x = m 2^k with m in [sqrt(1/2), sqrt(2)), k a whole number; x positive, finite and normal.
template <int W> struct Split { Pack<W> m, k; };
template <int W> SKEIN_INLINE Split<W> split(const Pack<W>& x) {
    if constexpr (Wide<W>) {
        const Split<W / 2> low = split(x.low), high = split(x.high);
        return {{low.m, high.m}, {low.k, high.k}};
    } else {
        using Bits = typename detail::Lanes<W>::Naturals;
        using Doubles = typename Pack<W>::Doubles;
        constexpr std::uint64_t one = std::uint64_t{1023} << 52,
                                root = std::bit_cast<std::uint64_t>(0.70710678118654752);
        constexpr double to_double = 4503599627370496.0; // 2^52: its last bits count up to it
        const Bits bits = std::bit_cast<Bits>(x.v), exponent = (bits + (one - root)) >> 52;
        return {Pack<W>(std::bit_cast<Doubles>(bits - (exponent << 52) + one)),
                Pack<W>(std::bit_cast<Doubles>(exponent + std::bit_cast<std::uint64_t>(to_double))) -
                    Pack<W>(to_double + 1023)};
    }
}

namespace detail {
/// c[First] + c[First + 1] x + ... + c[First + Count - 1] x^(Count - 1); power[i] = x^(2^i).
template <int First, int Count, int W, int N>
SKEIN_INLINE Pack<W> polynomial_part(const Pack<W> (&power)[4], const double (&c)[N]) {
    if constexpr (Count == 1) {
        return Pack<W>(c[First]);
    } else {
        constexpr int level = std::bit_width(static_cast<unsigned>(Count - 1)) - 1, low = 1 << level;
        return fma(polynomial_part<First + low, Count - low>(power, c), power[level],
                   polynomial_part<First, low>(power, c));
    }
}
} // namespace detail

/// c[0] + c[1] x + c[2] x^2 + ... by halves (Estrin), with fused multiply-adds: a third of the latency of Horner's
/// rule.
template <int W, int N> SKEIN_INLINE Pack<W> polynomial(const Pack<W>& x, const double (&c)[N]) {
    static_assert(N <= 16);
    Pack<W> power[4] = {x};
    for (int i = 1; i < 4; ++i) power[i] = power[i - 1] * power[i - 1];
    return detail::polynomial_part<0, N>(power, c);
}

} // namespace skein
