// Left-packing: the selected lanes of a pack, one after another.
#pragma once

#include "skein/core/pack.hpp"

#include <bit>
#include <cstdint>

namespace skein {

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

} // namespace skein
