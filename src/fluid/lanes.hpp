// Packs of eight adjacent numbers in memory, and exchanges of their lanes.
#pragma once

#include "skein/core/pack.hpp"

#include <cstring>

namespace skein {

/// Loads without alignment.
template <int W> SKEIN_INLINE Pack<W> load(const double* from) {
    if constexpr (Wide<W>) {
        return {load<W / 2>(from), load<W / 2>(from + W / 2)};
    } else {
        Pack<W> p;
        std::memcpy(&p.v, from, sizeof p.v);
        return p;
    }
}
template <int W> SKEIN_INLINE void store(double* to, const Pack<W>& p) {
    if constexpr (Wide<W>) {
        store(to, p.low);
        store(to + W / 2, p.high);
    } else std::memcpy(to, &p.v, sizeof p.v);
}

/// Keeps the first lanes and sets others to 0.
SKEIN_INLINE Pack<8> first_lanes(const Pack<8>& p, int lanes) {
    static constexpr double counting[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    return lanes >= 8 ? p : select(load<8>(counting) < Pack<8>(static_cast<double>(lanes)), p, Pack<8>(0.0));
}

/// Exchanges lanes 2 l and 2 l + 1.
template <int W> SKEIN_INLINE Pack<W> swapped(const Pack<W>& a) {
    if constexpr (Wide<W>) return {swapped(a.low), swapped(a.high)};
    else if constexpr (W == 8) return Pack<W>(__builtin_shufflevector(a.v, a.v, 1, 0, 3, 2, 5, 4, 7, 6));
    else if constexpr (W == 4) return Pack<W>(__builtin_shufflevector(a.v, a.v, 1, 0, 3, 2));
    else return Pack<W>(__builtin_shufflevector(a.v, a.v, 1, 0));
}

/// Transposes: r[i] lane j becomes r[j] lane i.
template <int W> SKEIN_INLINE void transpose(Pack<W> (&r)[W]) {
    if constexpr (Wide<W>) {
        Pack<W / 2> quarter[4][W / 2];
        for (int i = 0; i < W / 2; ++i) {
            quarter[0][i] = r[i].low;
            quarter[1][i] = r[i].high;
            quarter[2][i] = r[i + W / 2].low;
            quarter[3][i] = r[i + W / 2].high;
        }
        for (auto& q : quarter) transpose(q);
        for (int i = 0; i < W / 2; ++i) {
            r[i] = {quarter[0][i], quarter[2][i]};
            r[i + W / 2] = {quarter[1][i], quarter[3][i]};
        }
    } else if constexpr (W == 8) {
        typename Pack<W>::Doubles a[8], b[8];
        for (int i = 0; i < 8; i += 2) {
            a[i] = __builtin_shufflevector(r[i].v, r[i + 1].v, 0, 8, 2, 10, 4, 12, 6, 14);
            a[i + 1] = __builtin_shufflevector(r[i].v, r[i + 1].v, 1, 9, 3, 11, 5, 13, 7, 15);
        }
        for (int i = 0; i < 8; i += 4)
            for (int s = 0; s < 2; ++s) {
                b[i + s] = __builtin_shufflevector(a[i + s], a[i + s + 2], 0, 1, 8, 9, 4, 5, 12, 13);
                b[i + s + 2] = __builtin_shufflevector(a[i + s], a[i + s + 2], 2, 3, 10, 11, 6, 7, 14, 15);
            }
        for (int i = 0; i < 4; ++i) {
            r[i].v = __builtin_shufflevector(b[i], b[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
            r[i + 4].v = __builtin_shufflevector(b[i], b[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
        }
    } else if constexpr (W == 4) {
        const auto e01 = __builtin_shufflevector(r[0].v, r[1].v, 0, 4, 2, 6),
                   o01 = __builtin_shufflevector(r[0].v, r[1].v, 1, 5, 3, 7),
                   e23 = __builtin_shufflevector(r[2].v, r[3].v, 0, 4, 2, 6),
                   o23 = __builtin_shufflevector(r[2].v, r[3].v, 1, 5, 3, 7);
        r[0].v = __builtin_shufflevector(e01, e23, 0, 1, 4, 5);
        r[1].v = __builtin_shufflevector(o01, o23, 0, 1, 4, 5);
        r[2].v = __builtin_shufflevector(e01, e23, 2, 3, 6, 7);
        r[3].v = __builtin_shufflevector(o01, o23, 2, 3, 6, 7);
    } else {
        const auto even = __builtin_shufflevector(r[0].v, r[1].v, 0, 2),
                   odd = __builtin_shufflevector(r[0].v, r[1].v, 1, 3);
        r[0].v = even;
        r[1].v = odd;
    }
}

} // namespace skein
