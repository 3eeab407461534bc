// As many numbers of single precision as a register holds, for the first stages of the search.
#pragma once

#include "skein/core/pack.hpp"

#include <bit>
#include <cstdint>
#include <cstring>

namespace skein {

struct Floats {
    static constexpr int lanes = 2 * native_lanes;
    typedef float Numbers __attribute__((vector_size(4 * lanes)));
    typedef std::int32_t Integers __attribute__((vector_size(4 * lanes)));
    Numbers v;

    Floats() = default;
    SKEIN_INLINE Floats(Numbers x) : v(x) {}
    SKEIN_INLINE Floats(float x) : v(Numbers{} + x) {}
    SKEIN_INLINE static Floats at(const float* from) {
        Floats x;
        std::memcpy(&x.v, from, sizeof x.v);
        return x;
    }
    SKEIN_INLINE friend Floats operator+(Floats a, Floats b) { return a.v + b.v; }
    SKEIN_INLINE friend Floats operator-(Floats a, Floats b) { return a.v - b.v; }
    SKEIN_INLINE friend Floats operator*(Floats a, Floats b) { return a.v * b.v; }
    SKEIN_INLINE friend Floats operator/(Floats a, Floats b) { return a.v / b.v; }
    SKEIN_INLINE friend Floats max(Floats a, Floats b) { return a.v > b.v ? a.v : b.v; }
    SKEIN_INLINE friend Floats min(Floats a, Floats b) { return a.v < b.v ? a.v : b.v; }
    SKEIN_INLINE friend Floats abs(Floats a) {
        return std::bit_cast<Numbers>(std::bit_cast<Integers>(a.v) & 0x7fffffff);
    }
    SKEIN_INLINE friend Integers operator<(Floats a, Floats b) { return a.v < b.v; }

    /// Lanes that are not 0, as bits.
    SKEIN_INLINE static unsigned bits_of(Integers mask) {
#if defined(__AVX512DQ__)
        return _mm512_movepi32_mask(std::bit_cast<__m512i>(mask));
#elif defined(__AVX__)
        return static_cast<unsigned>(_mm256_movemask_ps(std::bit_cast<__m256>(mask)));
#else
        unsigned bits = 0;
        for (int l = 0; l < lanes; ++l) bits |= static_cast<unsigned>(mask[l] != 0) << l;
        return bits;
#endif
    }
    /// Lanes whose number in memory differs from `number`.
    SKEIN_INLINE static Integers differ(const std::int32_t* from, std::int32_t number) {
        Integers all;
        std::memcpy(&all, from, sizeof all);
        return all != number;
    }
};

struct Floats3 {
    Floats x, y, z;

    SKEIN_INLINE static Floats3 at(const float* x, const float* y, const float* z) {
        return {Floats::at(x), Floats::at(y), Floats::at(z)};
    }
    SKEIN_INLINE friend Floats3 operator-(const Floats3& a, const Floats3& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    SKEIN_INLINE friend Floats3 operator+(const Floats3& a, const Floats3& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    SKEIN_INLINE friend Floats3 operator*(Floats s, const Floats3& a) { return {s * a.x, s * a.y, s * a.z}; }
    SKEIN_INLINE friend Floats dot(const Floats3& a, const Floats3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
};

/// Copies the numbers whose bits are set, without gaps. `to` has room for all.
template <class T>
requires(sizeof(T) == 4) SKEIN_INLINE void compress_floats(T* to, unsigned bits, const T* from) {
#if defined(__AVX512F__)
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(static_cast<__mmask16>(bits), _mm512_loadu_si512(from)));
#else
    for (; bits != 0; bits &= bits - 1) *to++ = from[std::countr_zero(bits)];
#endif
}

} // namespace skein
