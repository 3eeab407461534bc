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
#if defined(__AVX512F__)
    if constexpr (W == 8) {
        const auto two = [&](int i) { return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(from[i])), _mm256_load_pd(from[i + 4]), 1); };
        const __m512d r0 = two(0), r1 = two(1), r2 = two(2), r3 = two(3);
        const __m512d even01 = _mm512_unpacklo_pd(r0, r1), odd01 = _mm512_unpackhi_pd(r0, r1), even23 = _mm512_unpacklo_pd(r2, r3), odd23 = _mm512_unpackhi_pd(r2, r3);
        const __m512i low = _mm512_set_epi64(13, 12, 5, 4, 9, 8, 1, 0), high = _mm512_set_epi64(15, 14, 7, 6, 11, 10, 3, 2);
        const auto pack = [](__m512d v) { return Pack<W>(std::bit_cast<typename Pack<W>::Doubles>(v)); };
        return {{pack(_mm512_permutex2var_pd(even01, low, even23)), pack(_mm512_permutex2var_pd(odd01, low, odd23)), pack(_mm512_permutex2var_pd(even01, high, even23))},
                pack(_mm512_permutex2var_pd(odd01, high, odd23))};
    }
#endif
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
