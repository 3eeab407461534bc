// Loads of contacts as they are added to elements: eight numbers at a time, a line of the cache, as slots have them.
#pragma once

#include "neighbourhood/exposure.hpp"

#include <cstring>
#include <type_traits>

namespace skein {

/// Load of a contact on an element: forces at its nodes, N, and a couple, N m; lab.
template <class P> struct ElementLoad { Vec3<P> first, second, couple; };

/// A force at an element and a couple on it: force[0..2], share of the element's length, couple[0..2], arm. The first
/// node has 1 - share of the force, the second share; the element has `arm` times the couple. Lab, N and N m (or N and
/// m, where the couple is n x T of a contact).
struct alignas(64) LoadRow {
    double number[8];
};
static_assert(sizeof(LoadRow) == sizeof(ExertedLoad) && std::is_trivially_default_constructible_v<LoadRow>);

/// A force on a node, and 0.
struct alignas(32) ForceRow {
    double number[4];
};

namespace detail {

template <int W> SKEIN_INLINE Pack<W> pack_at(const void* from) {
    Pack<W> pack;
    std::memcpy(&pack, __builtin_assume_aligned(from, 8 * W), sizeof pack);
    return pack;
}
template <int W> SKEIN_INLINE void put(void* to, const Pack<W>& pack) {
    std::memcpy(__builtin_assume_aligned(to, 8 * W), &pack, sizeof pack);
}
/// One number in the lower half, another one in the upper.
SKEIN_INLINE Pack<8> halves(double low, double high) {
#if defined(__AVX512F__)
    return Pack<8>(
        std::bit_cast<Pack<8>::Doubles>(_mm512_mask_blend_pd(0xf0, _mm512_set1_pd(low), _mm512_set1_pd(high))));
#else
    return {Pack<4>(low), Pack<4>(high)};
#endif
}

SKEIN_INLINE Pack<8> whole(const LoadRow& row) { return pack_at<8>(&row); }
SKEIN_INLINE Pack<8> whole(const ForceRow& row) { // read as it was written
#if defined(__AVX512F__)
    return Pack<8>(std::bit_cast<Pack<8>::Doubles>(_mm512_zextpd256_pd512(std::bit_cast<__m256d>(pack_at<4>(&row)))));
#else
    return {pack_at<4>(&row), Pack<4>(0.0)};
#endif
}
SKEIN_INLINE const LoadRow& as_load(const LoadRow& row) { return row; }
SKEIN_INLINE LoadRow as_load(const ForceRow& row) { return {row.number[0], row.number[1], row.number[2]}; }

} // namespace detail

/// Adds `first` times a row's force and `arm` times its couple to a slot, and `second` times the force to the next
/// slot. Whole lines are written, as a line written in parts has to reach the cache before it can be read whole.
/// Numbers between the vectors are 0, or nobody reads their sums.
SKEIN_INLINE void add_row(ExertedLoad* at, const Pack<8>& row, double first, double second, double arm) {
    using namespace detail;
    put(at, fma(row, halves(first, arm), pack_at<8>(at)));
    put(at + 1, fma(row, halves(second, 0), pack_at<8>(at + 1)));
}
/// Adds all that a row has to one slot.
template <class Row> SKEIN_INLINE void add_whole_row(ExertedLoad* at, const Row& row) {
    detail::put(at, detail::pack_at<8>(at) + detail::whole(row));
}
SKEIN_INLINE void add_row(ExertedLoad* at, const LoadRow& row) {
    const double share = row.number[3], arm = row.number[7];
    add_row(at, detail::pack_at<8>(&row), 1 - share, share, arm);
}

} // namespace skein
