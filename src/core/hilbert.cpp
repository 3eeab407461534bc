// Hilbert index in three dimensions by J. Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707, 381 (2004).
// Turns of the curve are undone level by level. A Gray code then makes the index's bits from the coordinates of the
// cell. Cost: 60 bit operations per level of 3 bits.
#include "core/hilbert.hpp"

#include <algorithm>
#include <array>

namespace skein {

namespace {

constexpr int bits = 21; // bits per axis; three axes fill 63 bits
using Cell = std::array<std::uint32_t, 3>;

Cell cell_of(const double (&unit)[3]) {
    constexpr double cells = 1 << bits;
    Cell cell;
    for (std::size_t axis = 0; axis < 3; ++axis)
        cell[axis] = static_cast<std::uint32_t>(std::clamp(unit[axis] * cells, 0.0, cells - 1));
    return cell;
}

/// In each sub-cube the curve runs mirrored or with two axes swapped; undo both, from the coarsest level down.
void undo_turns(Cell& x) {
    for (std::uint32_t level = 1u << (bits - 1); level > 1; level >>= 1) {
        const std::uint32_t finer = level - 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (x[axis] & level) {
                x[0] ^= finer;
            } else {
                const std::uint32_t differing = (x[0] ^ x[axis]) & finer;
                x[0] ^= differing;
                x[axis] ^= differing;
            }
        }
    }
}

void gray_encode(Cell& x) {
    x[1] ^= x[0];
    x[2] ^= x[1];
    std::uint32_t flips = 0;
    for (std::uint32_t level = 1u << (bits - 1); level > 1; level >>= 1)
        if (x[2] & level) flips ^= level - 1;
    for (auto& coordinate : x) coordinate ^= flips;
}

std::uint64_t interleave(const Cell& x) {
    std::uint64_t key = 0;
    for (int bit = bits - 1; bit >= 0; --bit)
        for (const auto coordinate : x) key = key << 1 | (coordinate >> bit & 1);
    return key;
}

} // namespace

std::uint64_t hilbert_key(const double (&unit)[3]) {
    Cell cell = cell_of(unit);
    undo_turns(cell);
    gray_encode(cell);
    return interleave(cell);
}

} // namespace skein
