// Rods that relax and share nodes with others: each is solved by itself, for its loads and for unit forces at shared
// nodes. Then what all share is found, and they move together. theory.md (66a)
#pragma once

#include "relaxation/block_band.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/tile.hpp"

#include <span>
#include <vector>

namespace skein {

template <int W> class RelaxesTogether;

/// A tile between its own solution and the motion of all.
template <int W> struct RelaxingTile {
    const RelaxesTogether<W>* pass;
    RodTile<W> rod;
    int last = 0;                            ///< block
    Pack<W> power{};                         ///< of its loads at the present rates, W
    AlignedVector<BandVector<W>> correction; ///< [last + 1]
    AlignedVector<BandVector<W>> by_unit;    ///< [shared node][direction][last + 1]: correction by a unit force
    std::span<const int> shared;             ///< nodes

    const BandVector<W>& unit(std::size_t node, int direction, int k) const {
        return by_unit[(3 * node + to_index(direction)) * to_index(last + 1) + to_index(k)];
    }
};

/// What relaxes the rods of such tiles.
template <int W> class RelaxesTogether {
public:
    virtual ~RelaxesTogether() = default;
    /// Share of the farthest step that rods may take, where those with `against` move against their forces.
    virtual Pack<W> reach(const RelaxingTile<W>& tile, const Mask<W>& against) const = 0;
    /// New rates, with this share of the old ones; returns the largest share of the farthest step.
    virtual Pack<W> move(const RelaxingTile<W>& tile, const Pack<W>& kept, double h) const = 0;
    virtual void slow_down(const RelaxingTile<W>& tile, const Pack<W>& share) const = 0;
    virtual void note_residual(const RelaxingTile<W>& tile) const = 0;
};

/// Tiles of the cluster that this thread relaxes.
template <int W> std::vector<RelaxingTile<W>>& relaxing_tiles() {
    static thread_local std::vector<RelaxingTile<W>> tiles;
    return tiles;
}

} // namespace skein
