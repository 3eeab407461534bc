// Lanes of packs by bits: the selected ones one after another (left-packing), a number in them.
#pragma once

#include "skein/core/pack.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace skein {

/// Bit i: whether a bit of byte i is set, of eight bytes.
inline unsigned bits_of_bytes(const std::uint8_t* bytes, int bit = 0) {
    std::uint64_t eight;
    std::memcpy(&eight, bytes, 8);
    return static_cast<unsigned>((eight >> bit & 0x0101010101010101u) * 0x0102040810204080u >> 56);
}

/// Bytes with 1 where the bit is set.
inline std::uint64_t bytes_of_bits(unsigned bits) {
    const std::uint64_t spread = (bits & 0x7fu) * 0x0002040810204081u & 0x0101010101010101u;
    return spread | static_cast<std::uint64_t>(bits >> 7 & 1u) << 56;
}

/// Stores the lanes whose bits are set, without gaps. `to` has room for all.
template <int W> SKEIN_INLINE void compress_store(double* to, unsigned bits, const Pack<W>& from) {
#if defined(__AVX512F__)
    if constexpr (W == 8) {
        _mm512_storeu_pd(to, _mm512_maskz_compress_pd(static_cast<__mmask8>(bits), std::bit_cast<__m512d>(from.v)));
        return;
    }
#endif
    for (int lane = 0; lane < W; ++lane) {
        *to = from[lane];
        to += bits >> lane & 1;
    }
}

/// Stores eight numbers in memory likewise; `to` may be before `from` in one array.
template <class T>
requires(sizeof(T) == sizeof(double) && std::is_trivially_copyable_v<T>) SKEIN_INLINE
    void compress_store(T* to, unsigned bits, const T* from) {
    Pack<8> numbers;
    std::memcpy(&numbers, from, sizeof numbers);
    alignas(64) double packed[8];
    compress_store(packed, bits, numbers);
    std::memcpy(to, packed, sizeof packed);
}
SKEIN_INLINE void compress_store(std::uint32_t* to, unsigned bits, const std::uint32_t* from) {
#if defined(__AVX512VL__)
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                        _mm256_maskz_compress_epi32(static_cast<__mmask8>(bits),
                                                    _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from))));
#else
    for (; bits != 0; bits &= bits - 1) *to++ = from[std::countr_zero(bits)];
#endif
}
SKEIN_INLINE void compress_store(std::uint8_t* to, unsigned bits, const std::uint8_t* from) {
#if defined(__AVX512VL__)
    std::uint64_t eight, mask = bytes_of_bits(bits) * 0xff;
    std::memcpy(&eight, from, 8);
    eight = _pext_u64(eight, mask);
    std::memcpy(to, &eight, 8);
#else
    for (; bits != 0; bits &= bits - 1) *to++ = from[std::countr_zero(bits)];
#endif
}
/// Stores first + i for each bit i of eight that is set, without gaps.
SKEIN_INLINE void store_places(std::uint32_t* to, unsigned bits, std::uint32_t first) {
#if defined(__AVX512VL__)
    const __m256i all =
        _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(first)), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_maskz_compress_epi32(static_cast<__mmask8>(bits), all));
#else
    for (; bits != 0; bits &= bits - 1) *to++ = first + static_cast<std::uint32_t>(std::countr_zero(bits));
#endif
}
/// Bits among others, which are all that is left of these.
SKEIN_INLINE unsigned bits_among(unsigned bits, unsigned others) {
#if defined(__AVX512VL__)
    return _pext_u32(bits, others);
#else
    unsigned among = 0, at = 0;
    for (; others != 0; others &= others - 1, ++at) among |= (bits >> std::countr_zero(others) & 1u) << at;
    return among;
#endif
}

/// A number in the lanes whose bits are set, 0 in the others.
template <int W> SKEIN_INLINE Pack<W> where_set(unsigned bits, double value) {
#if defined(__AVX512F__)
    if constexpr (W == 8) {
        const auto lanes = _mm512_maskz_mov_pd(static_cast<__mmask8>(bits), _mm512_set1_pd(value));
        return std::bit_cast<typename Pack<W>::Doubles>(lanes);
    }
#endif
    Pack<W> lanes(0.0);
    for (int lane = 0; lane < lanes_of<W>; ++lane) lanes.set(lane, bits >> lane & 1 ? value : 0);
    return lanes;
}

} // namespace skein
