// Pack<dual>: a number with its slopes along some directions, in one lane. Physics that is written over Pack<W> gives
// its exact derivatives in this width (forward differentiation), by the same source. Include it before all templates
// that are to be instantiated so.
//   value v, slopes d:   f(a, b) has the slopes  df/da a.d + df/db b.d
// A choice (select, max) takes the slopes of what it chooses. Where a root is 0, slopes are taken as 0.
#pragma once

#include "skein/core/pack.hpp"

#include <limits>

namespace skein {

/// Attribute of operations that are called: one of them is eight of a plain pack, and inlined they take two minutes to
/// compile.
#define SKEIN_CALLED [[gnu::noinline]]

/// Directions of a dual number: two registers of AVX2, one of AVX-512.
inline constexpr int directions = 8;

template <> struct Mask<dual> {
    bool holds;

    bool operator[](int) const { return holds; }
    SKEIN_INLINE friend Mask operator&(Mask a, Mask b) { return {a.holds && b.holds}; }
    SKEIN_INLINE friend Mask operator|(Mask a, Mask b) { return {a.holds || b.holds}; }
    SKEIN_INLINE friend Mask operator!(Mask a) { return {!a.holds}; }
};

template <> struct Pack<dual> {
    static constexpr int width = dual;
    using Slopes = Pack<directions>;
    Slopes d;
    double v;

    Pack() = default;
    SKEIN_INLINE Pack(double value) : d(0.0), v(value) {}
    SKEIN_INLINE Pack(double value, const Slopes& slopes) : d(slopes), v(value) {}

    double operator[](int) const { return v; }
    /// A constant.
    void set(int, double value) { *this = Pack(value); }

    SKEIN_INLINE Pack& operator+=(const Pack& b) { return *this = *this + b; }
    SKEIN_INLINE Pack& operator-=(const Pack& b) { return *this = *this - b; }
    SKEIN_INLINE Pack& operator*=(const Pack& b) { return *this = *this * b; }

    SKEIN_CALLED friend Pack operator+(const Pack& a, const Pack& b) { return {a.v + b.v, a.d + b.d}; }
    SKEIN_CALLED friend Pack operator-(const Pack& a, const Pack& b) { return {a.v - b.v, a.d - b.d}; }
    SKEIN_CALLED friend Pack operator*(const Pack& a, const Pack& b) {
        return {a.v * b.v, fma(Slopes(a.v), b.d, Slopes(b.v) * a.d)};
    }
    SKEIN_CALLED friend Pack operator/(const Pack& a, const Pack& b) {
        const double inverse = 1 / b.v, q = a.v / b.v;
        return {q, Slopes(inverse) * fma(Slopes(-q), b.d, a.d)};
    }
    SKEIN_INLINE friend Pack operator-(const Pack& a) { return {-a.v, -a.d}; }
    SKEIN_INLINE friend Mask<dual> operator<(const Pack& a, const Pack& b) { return {a.v < b.v}; }
    SKEIN_INLINE friend Mask<dual> operator>(const Pack& a, const Pack& b) { return {a.v > b.v}; }
    SKEIN_INLINE friend Mask<dual> operator<=(const Pack& a, const Pack& b) { return {a.v <= b.v}; }
    SKEIN_INLINE friend Mask<dual> operator>=(const Pack& a, const Pack& b) { return {a.v >= b.v}; }
};

/// f(a.v) with its slope there.
SKEIN_INLINE Pack<dual> with_slope(const Pack<dual>& a, double value, double slope) {
    return {value, Pack<directions>(slope) * a.d};
}

SKEIN_INLINE unsigned bits_of(const Mask<dual>& m) { return m.holds ? 1 : 0; }
SKEIN_INLINE bool any(const Mask<dual>& m) { return m.holds; }
SKEIN_CALLED inline Pack<dual> fma(const Pack<dual>& a, const Pack<dual>& b, const Pack<dual>& c) {
    using Slopes = Pack<directions>;
    return {detail::fma_of_one(a.v, b.v, c.v), fma(Slopes(a.v), b.d, fma(Slopes(b.v), a.d, c.d))};
}
SKEIN_CALLED inline Pack<dual> fms(const Pack<dual>& a, const Pack<dual>& b, const Pack<dual>& c) {
    using Slopes = Pack<directions>;
    return {detail::fma_of_one(a.v, b.v, -c.v), fma(Slopes(a.v), b.d, fma(Slopes(b.v), a.d, -c.d))};
}
SKEIN_CALLED inline Pack<dual> fnma(const Pack<dual>& a, const Pack<dual>& b, const Pack<dual>& c) {
    using Slopes = Pack<directions>;
    return {detail::fma_of_one(-a.v, b.v, c.v), fma(Slopes(-a.v), b.d, fma(Slopes(-b.v), a.d, c.d))};
}
SKEIN_CALLED inline Pack<dual> sqrt(const Pack<dual>& a) {
    const double root = __builtin_sqrt(a.v);
    return with_slope(a, root, a.v > 0 ? 0.5 / root : 0.0);
}
SKEIN_INLINE Pack<dual> select(const Mask<dual>& m, const Pack<dual>& a, const Pack<dual>& b) {
    return m.holds ? a : b;
}
SKEIN_INLINE Pack<dual> abs(const Pack<dual>& a) { return a.v < 0 ? -a : a; }
SKEIN_INLINE Pack<dual> max(const Pack<dual>& a, const Pack<dual>& b) { return a.v < b.v ? b : a; }
SKEIN_INLINE Pack<dual> min(const Pack<dual>& a, const Pack<dual>& b) { return b.v < a.v ? b : a; }
SKEIN_INLINE Pack<dual> from_lane_before(const Pack<dual>& a) { return a; }
SKEIN_INLINE Pack<dual> from_lane_after(const Pack<dual>& a) { return a; }

} // namespace skein
