// Pairs of capsules eight at a time. Eight tiles are read before the first is worked on. The work on a tile is a chain
// of operations that wait for each other. Only without the reading between them do several chains fit into the window
// of a core.
#pragma once

#include "core/transposed.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <utility>

namespace skein {

/// Axes p + s d1 and q + t d2.
struct CapsuleTile {
    static constexpr int width = 8;
    Vec3<Pack<width>> p, d1, q, d2;
    Pack<width> radius_1, radius_2;
};

/// Calls work(i, tile) for i = 0, 8, 16, ... below `count`. ahead(i) is called once for every such i, before. pair(i):
/// first nodes of both elements of pair i, defined up to the end of the last tile.
template <class PairAt, class Ahead, class Work>
SKEIN_INLINE void for_capsule_tiles(std::size_t count, PairAt&& pair, Ahead&& ahead, Work&& work) {
    constexpr int W = CapsuleTile::width;
    constexpr std::size_t tiles = 8;
    CapsuleTile tile[tiles];
    for (std::size_t begin = 0; begin < count; begin += tiles * W) {
        const std::size_t end = std::min(count, begin + tiles * W);
        for (std::size_t i = begin; i < end; i += W) {
            for (std::size_t l = 0; l < W; ++l) ahead(i + l);
            const auto first = [&](int next) {
                return load_transposed<W>([&](int l) { return &pair(i + to_index(l)).first[next].position.x; });
            };
            const auto second = [&](int next) {
                return load_transposed<W>([&](int l) { return &pair(i + to_index(l)).second[next].position.x; });
            };
            const auto p = first(0), p_end = first(1), q = second(0), q_end = second(1);
            tile[(i - begin) / W] = {p.vector, p_end.vector - p.vector, q.vector, q_end.vector - q.vector, p.fourth,
                                     q.fourth};
        }
        for (std::size_t i = begin; i < end; i += W) work(i, tile[(i - begin) / W]);
    }
}

} // namespace skein
