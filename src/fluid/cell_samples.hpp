// Parts of a flow for output: boxes of cells, or of means over cubes of them, and blocks in which a field exceeds a
// threshold. All numbers have the same bits on any number of ranks and threads: sums over ranks go plane by plane, in
// order.
#pragma once

#include "fluid/cell_fields.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"

#include <array>
#include <span>
#include <vector>

namespace skein {

/// A box of cubes, `average` cells wide each, from cell `first` on.
struct CellBox {
    std::array<int, 3> first{0, 0, 0};
    std::array<int, 3> count{1, 1, 1}; ///< cubes
    int average = 1;

    friend bool operator==(const CellBox&, const CellBox&) = default;
};

class BoxSampler {
public:
    BoxSampler(const Communicator& comm, const Threads& threads, const FlowPlanes& flow, const CellBox& box);

    /// Of the box's planes of cubes: those of this rank, which has the last plane of cells in each.
    Slab planes() const { return planes_; }
    /// Takes up a field, as it is now. Collective.
    void begin(CellField field);
    /// Of `count` planes of cubes from `first` on, among those of this rank: [plane][row][cube][component].
    void sample(int first, int count, std::span<double> out) const;

private:
    /// Plane of cells, counted from this rank's first, at which a plane of cubes begins.
    int begin_of(int plane) const { return box_.first[2] + plane * box_.average - slab_.first; }
    std::size_t row_numbers() const;
    /// Adds the sums over squares of a plane of cells, of a row of cubes.
    void add_row(int k, int row, std::span<double> scratch, std::span<double> sum) const;

    Communicator comm_;
    const Threads& threads_;
    const FlowPlanes& flow_;
    CellBox box_;
    Slab slab_, planes_;
    CellField field_ = CellField::velocity;
    std::vector<double> from_below_; ///< of the first plane of cubes: sums of each plane of cells that a rank below has
};

class BlockSampler {
public:
    BlockSampler(const Communicator& comm, const Threads& threads, const FlowPlanes& flow, int edge);

    /// Finds the blocks in which the magnitude of a field exceeds a threshold, as it is now. Collective.
    void find(CellField criterion, double threshold);
    /// Their first cells over `edge`, by z, y, x; the same on all ranks.
    const std::vector<std::array<int, 3>>& blocks() const { return blocks_; }
    /// Of `count` blocks from `first` on the planes that this rank has.
    struct Piece {
        std::size_t first, count;
        int plane, planes;
    };
    /// Up to so many numbers each, where a block's share is not more.
    std::vector<Piece> pieces(std::size_t most_numbers) const;
    /// [block][plane][row][cell][component], not a number beyond the grid.
    void sample(CellField field, const Piece& piece, std::span<double> out) const;

private:
    /// Cells of the grid along a direction in a block.
    int extent(int direction, int block) const;

    Communicator comm_;
    const Threads& threads_;
    const FlowPlanes& flow_;
    int edge_;
    std::array<int, 3> cells_, counts_; ///< of the grid; blocks along each direction
    std::vector<std::array<int, 3>> blocks_;
};

} // namespace skein
