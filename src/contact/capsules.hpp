// What contact sees of rods: elements as capsules, one after another along their rods.
#pragma once

#include "core/aligned.hpp"
#include "core/vec3.hpp"

#include <cstdint>
#include <vector>

namespace skein {

/// One per slot. Element k of a rod lies between its slots k and k + 1; the last slot of a rod has no element.
struct CapsuleNode {
    Vec3d position;     ///< lab, m
    double radius;      ///< of the element, m; below 0 where the slot has none
    Vec3d velocity;     ///< lab, m/s
    double unused = 0;
};
static_assert(sizeof(CapsuleNode) == 64);
/// Of an element.
struct CapsuleSpin {
    Vec3d spin; ///< lab, rad/s
    double unused = 0;
};
static_assert(sizeof(CapsuleSpin) == 32);

/// Four numbers of W records each, transposed: a vector and what lies behind it.
template <int W> struct LoadedVectors {
    Vec3<Pack<W>> vector;
    Pack<W> behind;
};
template <int W> SKEIN_INLINE LoadedVectors<W> load_transposed(const double* const (&from)[W]) {
    if constexpr (W == 8) {
        typedef double Four __attribute__((vector_size(32), may_alias));
        const auto two = [&](int i) {
            return __builtin_shufflevector(*reinterpret_cast<const Four*>(from[i]), *reinterpret_cast<const Four*>(from[i + 4]), 0, 1, 2, 3, 4, 5, 6, 7);
        };
        const auto r0 = two(0), r1 = two(1), r2 = two(2), r3 = two(3);
        const auto even01 = __builtin_shufflevector(r0, r1, 0, 8, 2, 10, 4, 12, 6, 14), odd01 = __builtin_shufflevector(r0, r1, 1, 9, 3, 11, 5, 13, 7, 15);
        const auto even23 = __builtin_shufflevector(r2, r3, 0, 8, 2, 10, 4, 12, 6, 14), odd23 = __builtin_shufflevector(r2, r3, 1, 9, 3, 11, 5, 13, 7, 15);
        const auto low = [](auto a, auto b) { return Pack<W>(__builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13)); };
        const auto high = [](auto a, auto b) { return Pack<W>(__builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15)); };
        return {{low(even01, even23), low(odd01, odd23), high(even01, even23)}, high(odd01, odd23)};
    }
    LoadedVectors<W> all;
    for (int i = 0; i < W; ++i) {
        set_lane(all.vector, i, {from[i][0], from[i][1], from[i][2]});
        all.behind.set(i, from[i][3]);
    }
    return all;
}

/// Rods of a scene as they touch.
struct Capsules {
    AlignedVector<CapsuleNode> node;
    AlignedVector<CapsuleSpin> spin;
    std::vector<std::int32_t> rod;        ///< of each slot
    std::vector<std::int32_t> first_slot; ///< of each rod, and behind the last
    std::vector<std::int32_t> skip;       ///< per rod: its elements touch where their numbers differ by more; below 0: never

    std::size_t slots() const { return node.size(); }
    bool has_element(std::size_t slot) const { return node[slot].radius >= 0; }
    /// Elements that may touch, by what they are and not where.
    bool may_touch(std::size_t a, std::size_t b) const {
        if (rod[a] != rod[b]) return true;
        const std::int32_t gap = skip[static_cast<std::size_t>(rod[a])], apart = static_cast<std::int32_t>(a) - static_cast<std::int32_t>(b);
        return gap >= 0 && (apart > gap || -apart > gap);
    }
};

} // namespace skein
