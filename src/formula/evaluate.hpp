// Runs a list of instructions over a strip of places, W side by side. Each instruction runs over the whole strip, so
// that the choice of an operation is paid once a strip. Registers of a strip stay in the first cache. An instruction
// may fuse two operations: the value of the first never leaves the processor.
#pragma once

#include "formula/program.hpp"
#include "skein/core/index.hpp"
#include "skein/core/pack.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>

namespace skein {

/// Values of a source from place to place; step 0 where all are equal.
template <int W> struct Strided {
    const Pack<W>* at;
    std::ptrdiff_t step;

    SKEIN_INLINE const Pack<W>& operator[](int i) const { return at[i * step]; }
    SKEIN_INLINE Strided from(int i) const { return {at + i * step, step}; }
};

/// Largest number of packs in a strip: 2 kB a register at all widths.
template <int W> inline constexpr int strip = static_cast<int>(256 * sizeof(double) / sizeof(Pack<W>));
template <int W> struct StripRegisters { Pack<W> value[InstructionList::most_registers][strip<W>]; };

/// Value of a table, lane by lane.
template <int W> Pack<W> looked_up(const FormulaTable& table, Op op, const Pack<W>& x) {
    if constexpr (W == dual) // the slope of a slope is 0, but for corners
        return op == Op::tabulated ? with_slope(x, table(x[0]), table.slope(x[0])) : Pack<W>(table.slope(x[0]));
    Pack<W> r;
    for (int i = 0; i < lanes_of<W>; ++i) r.set(i, op == Op::tabulated ? table(x[i]) : table.slope(x[i]));
    return r;
}

/// True where |a| <= most at all places. Bits are compared, as their order is that of the numbers.
template <int W> SKEIN_INLINE bool all_within(double most, const Strided<W>& a, int count) {
    Pack<W> beyond(1.0); // negative where one value was beyond
    for (int i = 0; i < count; ++i)
        beyond = detail::of_bits(
            beyond, a[i], [most](const auto& b, const auto& x) __attribute__((always_inline)) {
                return b | (std::bit_cast<std::uint64_t>(most) - (x & ~detail::sign_bit));
            });
    return !any(detail::times_sign(Pack<W>(1.0), beyond) < Pack<W>(0.0));
}

/// Sets the sources of a list's constants, which `same` holds in all lanes.
template <int W> void spread_constants(const InstructionList& list, Pack<W>* same, Strided<W>* source) {
    for (std::size_t i = 0; i < list.constants.size(); ++i) {
        same[i] = Pack<W>(list.constants[i]);
        source[to_index(list.registers) + i] = {&same[i], 0};
    }
}

/// Evaluates a list over a strip. `source` [list.sources()] holds the inputs and constants of this strip; `count` is at
/// most strip<W>.
template <int W> void evaluate(const InstructionList& list, std::span<const FormulaTable> tables, Strided<W>* source,
                               StripRegisters<W>& registers, int count) {
    for (int r = 0; r < list.registers; ++r) source[r] = {registers.value[r], 1};
    for (const Instruction& in : list.code) {
        Pack<W>* to = registers.value[in.to];
        const Strided<W> a = source[in.a], b = in.b >= 0 ? source[in.b] : a, c = in.c >= 0 ? source[in.c] : a;
        if (in.op == Op::tabulated || in.op == Op::tabulated_slope) {
            for (int i = 0; i < count; ++i) to[i] = looked_up(nth(tables, in.table), in.op, a[i]);
            continue;
        }
        if (!in.then) {
            with_operation(in.op, [&]<Op op>() {
                if constexpr (largest_ordinary < op >> 0 && W != dual)
                    if (all_within(largest_ordinary<op>, a, count)) {
                        for (int i = 0; i < count; ++i) to[i] = operate_ordinary<op>(a[i]);
                        return;
                    }
                for (int i = 0; i < count; ++i) to[i] = operate<op>(a[i], b[i], c[i]);
            });
            continue;
        }
        with_arithmetic(in.op, [&]<Op op>() {
            with_arithmetic(*in.then, [&]<Op then>() {
                if (in.reversed)
                    for (int i = 0; i < count; ++i) to[i] = operate_twice<op, then, true>(a[i], b[i], c[i]);
                else
                    for (int i = 0; i < count; ++i) to[i] = operate_twice<op, then, false>(a[i], b[i], c[i]);
            });
        });
    }
}

} // namespace skein
