// Operations of formulas on packs. Each is defined once for all widths, and set-up folds constants with it too.
#pragma once

#include "formula/arc_tangent.hpp"
#include "formula/circular.hpp"
#include "formula/exponentials.hpp"
#include "formula/lane_bits.hpp"
#include "skein/core/pack.hpp"

#include <cstdint>

namespace skein {

/// A constant, a variable, then functions of one, two and three values. `tabulated` and `tabulated_slope` read a table.
enum class Op : std::uint8_t {
    constant,
    variable,
    negative,
    absolute,
    root,
    floor,
    sine,
    cosine,
    exponential,
    logarithm,
    hyperbolic_tangent,
    tabulated,
    tabulated_slope,
    add,
    subtract,
    multiply,
    divide,
    power,
    arc_tangent, ///< angle of a/b, in all quadrants
    least,
    most,
    less,       ///< 1 where a < b, 0 elsewhere
    less_equal, ///< 1 where a <= b, 0 elsewhere
    equal,
    choice, ///< b where a is not 0, else c
};

inline int operands_of(Op op) {
    if (op <= Op::variable) return 0;
    if (op <= Op::tabulated_slope) return 1;
    return op < Op::choice ? 2 : 3;
}

inline bool is_arithmetic(Op op) { return op >= Op::add && op <= Op::divide; }

namespace detail {

template <int W> SKEIN_INLINE Pack<W> whole_below(const Pack<W>& x) {
    constexpr double all_whole = 4503599627370496.0; // 2^52: larger numbers are whole
    const Pack<W> size = size_of(x), nearest = times_sign((size + Pack<W>(all_whole)) - Pack<W>(all_whole), x);
    return select(size < Pack<W>(all_whole), select(nearest > x, nearest - Pack<W>(1.0), nearest), x);
}

} // namespace detail

/// Result for operands a, b and c, as many as the operation has; not for constants, variables and tables.
template <Op op, int W> SKEIN_INLINE Pack<W> operate(const Pack<W>& a, const Pack<W>& b, const Pack<W>& c) {
    using P = Pack<W>;
    const auto truth = [](const Mask<W>& m) { return select(m, P(1.0), P(0.0)); };
    if constexpr (op == Op::negative) return -a;
    if constexpr (op == Op::absolute) return detail::size_of(a);
    if constexpr (op == Op::root) return sqrt(a);
    if constexpr (op == Op::floor) return detail::whole_below(a);
    if constexpr (op == Op::sine) return sin(a);
    if constexpr (op == Op::cosine) return cos(a);
    if constexpr (op == Op::exponential) return exponential(a);
    if constexpr (op == Op::logarithm) return logarithm(a);
    if constexpr (op == Op::hyperbolic_tangent) return hyperbolic_tangent(a);
    if constexpr (op == Op::add) return a + b;
    if constexpr (op == Op::subtract) return a - b;
    if constexpr (op == Op::multiply) return a * b;
    if constexpr (op == Op::divide) return a / b;
    if constexpr (op == Op::power) return power(a, b);
    if constexpr (op == Op::arc_tangent) return arc_tangent(a, b);
    if constexpr (op == Op::least) return min(a, b);
    if constexpr (op == Op::most) return max(a, b);
    if constexpr (op == Op::less) return truth(a < b);
    if constexpr (op == Op::less_equal) return truth(a <= b);
    if constexpr (op == Op::equal) return truth((a <= b) & (a >= b));
    if constexpr (op == Op::choice) return select((a < P(0.0)) | (a > P(0.0)), b, c);
    return a;
}

/// Largest |a| for which an operation has a shorter way to the same bits, operate_ordinary(); 0 where it has none.
template <Op op> inline constexpr double largest_ordinary = 0;
template <> inline constexpr double largest_ordinary<Op::sine> = detail::largest_angle;
template <> inline constexpr double largest_ordinary<Op::cosine> = detail::largest_angle;
template <> inline constexpr double largest_ordinary<Op::exponential> = detail::largest_exponent;
template <Op op, int W> SKEIN_INLINE Pack<W> operate_ordinary(const Pack<W>& a) {
    if constexpr (op == Op::sine) return detail::sine_of_ordinary<0>(a);
    else if constexpr (op == Op::cosine) return detail::sine_of_ordinary<1>(a);
    else return detail::exponential_of_ordinary(a);
}

/// Result of `then` for (a op b) and c, or for c and (a op b); each operation is rounded as if alone.
template <Op op, Op then, bool reversed, int W>
SKEIN_INLINE Pack<W> operate_twice(const Pack<W>& a, const Pack<W>& b, const Pack<W>& c) {
    const Pack<W> r = operate<op>(a, b, b);
    if constexpr (reversed) return operate<then>(c, r, r);
    else return operate<then>(r, c, c);
}

/// Calls f.template operator()<op>() for a sum, difference, product or quotient that is known at run time.
template <class F> SKEIN_INLINE void with_arithmetic(Op op, F&& f) {
    if (op == Op::add) f.template operator()<Op::add>();
    else if (op == Op::subtract) f.template operator()<Op::subtract>();
    else if (op == Op::multiply) f.template operator()<Op::multiply>();
    else f.template operator()<Op::divide>();
}

/// Calls f.template operator()<op>() for an operation that is known at run time.
template <class F> SKEIN_INLINE void with_operation(Op op, F&& f) {
    switch (op) {
    case Op::negative:
        return f.template operator()<Op::negative>();
    case Op::absolute:
        return f.template operator()<Op::absolute>();
    case Op::root:
        return f.template operator()<Op::root>();
    case Op::floor:
        return f.template operator()<Op::floor>();
    case Op::sine:
        return f.template operator()<Op::sine>();
    case Op::cosine:
        return f.template operator()<Op::cosine>();
    case Op::exponential:
        return f.template operator()<Op::exponential>();
    case Op::logarithm:
        return f.template operator()<Op::logarithm>();
    case Op::hyperbolic_tangent:
        return f.template operator()<Op::hyperbolic_tangent>();
    case Op::add:
        return f.template operator()<Op::add>();
    case Op::subtract:
        return f.template operator()<Op::subtract>();
    case Op::multiply:
        return f.template operator()<Op::multiply>();
    case Op::divide:
        return f.template operator()<Op::divide>();
    case Op::power:
        return f.template operator()<Op::power>();
    case Op::arc_tangent:
        return f.template operator()<Op::arc_tangent>();
    case Op::least:
        return f.template operator()<Op::least>();
    case Op::most:
        return f.template operator()<Op::most>();
    case Op::less:
        return f.template operator()<Op::less>();
    case Op::less_equal:
        return f.template operator()<Op::less_equal>();
    case Op::equal:
        return f.template operator()<Op::equal>();
    case Op::choice:
        return f.template operator()<Op::choice>();
    case Op::constant:
    case Op::variable:
    case Op::tabulated:
    case Op::tabulated_slope:
        return;
    }
}

} // namespace skein
