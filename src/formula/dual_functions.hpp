// Functions of formulas and loads for dual numbers: values as they are for one lane, and their slopes.
#pragma once

#include "core/logarithm.hpp"
#include "formula/arc_tangent.hpp"
#include "formula/circular.hpp"
#include "formula/exponentials.hpp"
#include "formula/operation.hpp"
#include "skein/core/dual_pack.hpp"

namespace skein {

namespace detail {
/// Value of a function of one number, as in one lane.
template <class F> double in_one_lane(F&& f, double x) { return f(Pack<1>(x))[0]; }

template <> SKEIN_INLINE Pack<dual> size_of<dual>(const Pack<dual>& x) { return abs(x); }
template <> SKEIN_INLINE Pack<dual> whole_below<dual>(const Pack<dual>& x) { return std::floor(x.v); }
} // namespace detail

inline Pack<dual> sin(const Pack<dual>& x) {
    const auto value = [](const Pack<1>& a) { return sin(a); };
    const auto slope = [](const Pack<1>& a) { return cos(a); };
    return with_slope(x, detail::in_one_lane(value, x.v), detail::in_one_lane(slope, x.v));
}
inline Pack<dual> cos(const Pack<dual>& x) {
    const auto value = [](const Pack<1>& a) { return cos(a); };
    const auto slope = [](const Pack<1>& a) { return sin(a); };
    return with_slope(x, detail::in_one_lane(value, x.v), -detail::in_one_lane(slope, x.v));
}
inline Pack<dual> exponential(const Pack<dual>& x) {
    const double value = detail::in_one_lane([](const Pack<1>& a) { return exponential(a); }, x.v);
    return with_slope(x, value, value);
}
inline Pack<dual> logarithm(const Pack<dual>& x) {
    return with_slope(x, detail::in_one_lane([](const Pack<1>& a) { return logarithm(a); }, x.v), 1 / x.v);
}
inline Pack<dual> log(const Pack<dual>& x) {
    return with_slope(x, detail::in_one_lane([](const Pack<1>& a) { return log(a); }, x.v), 1 / x.v);
}
inline Pack<dual> hyperbolic_tangent(const Pack<dual>& x) {
    const double value = detail::in_one_lane([](const Pack<1>& a) { return hyperbolic_tangent(a); }, x.v);
    return with_slope(x, value, 1 - value * value);
}
/// a^b: slopes b a^(b - 1) and, where a is positive, a^b ln(a).
inline Pack<dual> power(const Pack<dual>& a, const Pack<dual>& b) {
    using Slopes = Pack<dual>::Slopes;
    const double value = power(Pack<1>(a.v), Pack<1>(b.v))[0];
    const double by_a = b.v == 0 ? 0 : b.v * power(Pack<1>(a.v), Pack<1>(b.v - 1))[0];
    const double by_b = a.v > 0 ? value * logarithm(Pack<1>(a.v))[0] : 0;
    return {value, fma(Slopes(by_a), a.d, Slopes(by_b) * b.d)};
}
/// Angle of a/b.
inline Pack<dual> arc_tangent(const Pack<dual>& a, const Pack<dual>& b) {
    using Slopes = Pack<dual>::Slopes;
    const double inv = 1 / (a.v * a.v + b.v * b.v);
    return {arc_tangent(Pack<1>(a.v), Pack<1>(b.v))[0], Slopes(inv) * (Slopes(b.v) * a.d - Slopes(a.v) * b.d)};
}

} // namespace skein
