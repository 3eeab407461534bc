// How ranks share the cells of a fluid.
#pragma once

#include "fluid/fluid_grid.hpp"

#include <algorithm>
#include <string>

namespace skein {

/// Slabs of planes along z, each of ranks that follow each other and share its rows, of which each has all cells along
/// x. Rows stay in the pairs whose transforms are one, and coefficients along x in the packs whose columns are.
class Pencils {
public:
    Pencils(const FluidGrid& grid, int rank, int ranks, int across = 1)
        : cells_(grid.cells), rank_(rank), ranks_(ranks), across_(across), planes_(planes(slab())),
          rows_(rows(share())) {}

    int ranks() const { return ranks_; }
    int across() const { return across_; } ///< ranks of a slab
    int slabs() const { return ranks_ / across_; }
    int rank_of(int slab, int share) const { return slab * across_ + share; }
    int rank_of_cell(int row, int plane) const {
        return rank_of(rank_of_plane(plane, cells_[2], slabs()), rank_of_plane(row / 2, pairs(), across_));
    }
    Slab planes(int slab) const { return slab_of(cells_[2], slab, slabs()); }
    Slab rows(int share) const { return in_cells(slab_of(pairs(), share, across_), 2, cells_[1]); }
    /// Coefficients along x that a share has along the whole of y.
    Slab modes(int share) const { return in_cells(slab_of((cells_[0] + 7) / 8, share, across_), 8, cells_[0]); }

    /// Of this rank.
    int slab() const { return rank_ / across_; }
    int share() const { return rank_ % across_; }
    const Slab& planes() const { return planes_; }
    const Slab& rows() const { return rows_; }
    FieldLayout layout() const { return {cells_[0], rows_.count, planes_.count}; }

private:
    int pairs() const { return (cells_[1] + 1) / 2; }
    static Slab in_cells(const Slab& units, int unit, int cells) {
        const int first = std::min(unit * units.first, cells);
        return {first, std::min(unit * units.count, cells - first)};
    }

    std::array<int, 3> cells_;
    int rank_, ranks_, across_;
    Slab planes_, rows_;
};

/// Most slabs and most ranks of a slab: planes and rows of a rank are at least as many as the ghosts of its neighbours.
inline int most_slabs(const FluidGrid& grid) { return std::max(1, grid.cells[2] / FieldLayout::ghosts); }
inline int most_across(const FluidGrid& grid) { return std::max(1, grid.cells[1] / FieldLayout::ghosts); }

/// The fewest ranks of a slab with which so many ranks can share a fluid; 0: none.
int fewest_across(const FluidGrid& grid, int ranks);
/// Why so many ranks, `across` of them in a slab, cannot share a fluid; empty: they can.
std::string unshared(const FluidGrid& grid, int ranks, int across);

} // namespace skein
