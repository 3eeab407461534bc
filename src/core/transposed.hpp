// Four numbers of W records each, transposed: a vector and the number after it. at(lane) gives the place of a lane's
// numbers, on a multiple of 32 bytes. It is a function, as dozens of pointers would go through memory.
#pragma once

#include "skein/core/index.hpp"
#include "skein/core/vec3.hpp"

#include <array>
#include <bit>

namespace skein {

template <int W> struct LoadedVectors {
    Vec3<Pack<W>> vector;
    Pack<W> fourth;
};

namespace detail {
typedef double FourDoubles __attribute__((vector_size(32), may_alias));
} // namespace detail

template <int W, class At> SKEIN_INLINE LoadedVectors<W> load_transposed(At&& at) {
    using Four [[maybe_unused]] = detail::FourDoubles;
    if constexpr (Wide<W> && W > 2) {
        const LoadedVectors<W / 2> low = load_transposed<W / 2>(at),
                                   high = load_transposed<W / 2>([&](int i) { return at(i + W / 2); });
        return {{{low.vector.x, high.vector.x}, {low.vector.y, high.vector.y}, {low.vector.z, high.vector.z}},
                {low.fourth, high.fourth}};
    } else if constexpr (W == 4) {
        const auto row = [&](int i) __attribute__((always_inline)) { return *reinterpret_cast<const Four*>(at(i)); };
        const auto r0 = row(0), r1 = row(1), r2 = row(2), r3 = row(3);
        const auto even01 = __builtin_shufflevector(r0, r1, 0, 4, 2, 6),
                   odd01 = __builtin_shufflevector(r0, r1, 1, 5, 3, 7);
        const auto even23 = __builtin_shufflevector(r2, r3, 0, 4, 2, 6),
                   odd23 = __builtin_shufflevector(r2, r3, 1, 5, 3, 7);
        const auto low = [](auto a, auto b) __attribute__((always_inline)) {
            return Pack<W>(__builtin_shufflevector(a, b, 0, 1, 4, 5));
        };
        const auto high = [](auto a, auto b) __attribute__((always_inline)) {
            return Pack<W>(__builtin_shufflevector(a, b, 2, 3, 6, 7));
        };
        return {{low(even01, even23), low(odd01, odd23), high(even01, even23)}, high(odd01, odd23)};
    } else if constexpr (W == 8) {
        const auto two = [&](int i) __attribute__((always_inline)) {
            return __builtin_shufflevector(*reinterpret_cast<const Four*>(at(i)),
                                           *reinterpret_cast<const Four*>(at(i + 4)), 0, 1, 2, 3, 4, 5, 6, 7);
        };
        const auto r0 = two(0), r1 = two(1), r2 = two(2), r3 = two(3);
        const auto even01 = __builtin_shufflevector(r0, r1, 0, 8, 2, 10, 4, 12, 6, 14),
                   odd01 = __builtin_shufflevector(r0, r1, 1, 9, 3, 11, 5, 13, 7, 15);
        const auto even23 = __builtin_shufflevector(r2, r3, 0, 8, 2, 10, 4, 12, 6, 14),
                   odd23 = __builtin_shufflevector(r2, r3, 1, 9, 3, 11, 5, 13, 7, 15);
        const auto low = [](auto a, auto b) __attribute__((always_inline)) {
            return Pack<W>(__builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13));
        };
        const auto high = [](auto a, auto b) __attribute__((always_inline)) {
            return Pack<W>(__builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15));
        };
        return {{low(even01, even23), low(odd01, odd23), high(even01, even23)}, high(odd01, odd23)};
    } else if constexpr (lanes_of<W> == 1) {
        const double* one = at(0);
        return {{Pack<W>(one[0]), Pack<W>(one[1]), Pack<W>(one[2])}, Pack<W>(one[3])};
    } else {
        std::array<double, W> number[4];
        for (int i = 0; i < W; ++i)
            for (int n = 0; n < 4; ++n) nth(number[n], i) = at(i)[n];
        const auto pack = [&](int n) { return std::bit_cast<Pack<W>>(number[n]); };
        return {{pack(0), pack(1), pack(2)}, pack(3)};
    }
}

template <int W, class At>
SKEIN_INLINE void store_transposed(const Vec3<Pack<W>>& vector, const Pack<W>& fourth, At&& at) {
    using Four [[maybe_unused]] = detail::FourDoubles;
    if constexpr (Wide<W> && W > 2) {
        store_transposed<W / 2>({vector.x.low, vector.y.low, vector.z.low}, fourth.low, at);
        store_transposed<W / 2>({vector.x.high, vector.y.high, vector.z.high}, fourth.high,
                                [&](int i) { return at(i + W / 2); });
    } else if constexpr (W == 4) {
        const auto xy_even = __builtin_shufflevector(vector.x.v, vector.y.v, 0, 4, 2, 6), // records 0 and 2
            xy_odd = __builtin_shufflevector(vector.x.v, vector.y.v, 1, 5, 3, 7);         // records 1 and 3
        const auto zw_even = __builtin_shufflevector(vector.z.v, fourth.v, 0, 4, 2, 6),
                   zw_odd = __builtin_shufflevector(vector.z.v, fourth.v, 1, 5, 3, 7);
        const auto put = [&](int first, auto xy, auto zw) __attribute__((always_inline)) {
            *reinterpret_cast<Four*>(at(first)) = __builtin_shufflevector(xy, zw, 0, 1, 4, 5);
            *reinterpret_cast<Four*>(at(first + 2)) = __builtin_shufflevector(xy, zw, 2, 3, 6, 7);
        };
        put(0, xy_even, zw_even);
        put(1, xy_odd, zw_odd);
    } else if constexpr (W == 8) {
        const auto even = [](auto a, auto b) __attribute__((always_inline)) {
            return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
        };
        const auto odd = [](auto a, auto b) __attribute__((always_inline)) {
            return __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
        };
        const auto xy_even = even(vector.x.v, vector.y.v),
                   xy_odd = odd(vector.x.v, vector.y.v); // records 0 2 4 6, and 1 3 5 7
        const auto zw_even = even(vector.z.v, fourth.v), zw_odd = odd(vector.z.v, fourth.v);
        const auto put = [&](int first, auto xy, auto zw) __attribute__((always_inline)) {
            *reinterpret_cast<Four*>(at(first)) = __builtin_shufflevector(xy, zw, 0, 1, 8, 9);
            *reinterpret_cast<Four*>(at(first + 2)) = __builtin_shufflevector(xy, zw, 2, 3, 10, 11);
            *reinterpret_cast<Four*>(at(first + 4)) = __builtin_shufflevector(xy, zw, 4, 5, 12, 13);
            *reinterpret_cast<Four*>(at(first + 6)) = __builtin_shufflevector(xy, zw, 6, 7, 14, 15);
        };
        put(0, xy_even, zw_even);
        put(1, xy_odd, zw_odd);
    } else {
        for (int i = 0; i < lanes_of<W>; ++i) {
            double* to = at(i);
            to[0] = vector.x[i];
            to[1] = vector.y[i];
            to[2] = vector.z[i];
            to[3] = fourth[i];
        }
    }
}

} // namespace skein
