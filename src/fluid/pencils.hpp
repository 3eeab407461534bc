// Distribution of the cells of a fluid over ranks.
#pragma once

#include "fluid/fluid_grid.hpp"

#include <algorithm>
#include <string>

namespace skein {

/// Slabs of planes along z. Consecutive ranks share the rows of a slab, and rows have all cells along x. A rank has
/// whole pairs of rows, which are transformed as one, and whole packs of coefficients along x, which are solved as one.
class Pencils {
public:
    Pencils(const FluidGrid& grid, int rank, int ranks, int across = 1)
        : cells_(grid.cells), rank_(rank), ranks_(ranks), across_(across), planes_(planes(slab())),
          rows_(rows(share())) {}

    int ranks() const { return ranks_; }
    int across() const { return across_; } ///< number of ranks of a slab
    int slabs() const { return ranks_ / across_; }
    int rank_of(int slab, int share) const { return slab * across_ + share; }
    int rank_of_cell(int row, int plane) const {
        return rank_of(rank_of_plane(plane, cells_[2], slabs()), rank_of_plane(row / 2, pairs(), across_));
    }
    Slab planes(int slab) const { return slab_of(cells_[2], slab, slabs()); }
    Slab rows(int share) const { return in_cells(slab_of(pairs(), share, across_), 2, cells_[1]); }
    /// Coefficients along x of a share, for all of y.
    Slab modes(int share) const { return in_cells(slab_of((cells_[0] + 7) / 8, share, across_), 8, cells_[0]); }

    /// Slab, share, planes, rows and layout of this rank.
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

/// Largest numbers of slabs, and of ranks of a slab: a rank has at least as many planes and rows as there are ghosts.
inline int most_slabs(const FluidGrid& grid) { return std::max(1, grid.cells[2] / FieldLayout::ghosts); }
inline int most_across(const FluidGrid& grid) { return std::max(1, grid.cells[1] / FieldLayout::ghosts); }

/// Least number of ranks of a slab by which so many ranks can share a fluid; 0: none.
int fewest_across(const FluidGrid& grid, int ranks);
/// Reason why so many ranks, `across` in each slab, cannot share a fluid; empty if they can.
std::string unshared(const FluidGrid& grid, int ranks, int across);

} // namespace skein
