// Parts of a flow for output: boxes of cells or of means over cubes, and blocks in which a field exceeds a threshold.
// Sums over ranks follow the order of planes, so any number of ranks and threads gives the same bits.
#pragma once

#include "fluid/cell_fields.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"

#include <array>
#include <span>
#include <vector>

namespace skein {

/// Box of cubes with edges of `average` cells, from cell `first` on.
struct CellBox {
    std::array<int, 3> first{0, 0, 0};
    std::array<int, 3> count{1, 1, 1}; ///< numbers of cubes
    int average = 1;

    friend bool operator==(const CellBox&, const CellBox&) = default;
};

class BoxSampler {
public:
    BoxSampler(const Communicator& comm, const Threads& threads, const FlowPlanes& flow, const CellBox& box);

    /// Planes of cubes whose last plane of cells belongs to this rank.
    Slab planes() const { return planes_; }
    /// Starts with a field of the present flow. Collective.
    void begin(CellField field);
    /// Writes `count` of planes() from `first` on, [plane][row][cube][component].
    void sample(int first, int count, std::span<double> out) const;

private:
    /// First plane of cells of a plane of cubes, counted from this rank's first.
    int begin_of(int plane) const { return box_.first[2] + plane * box_.average - slab_.first; }
    std::size_t row_numbers() const;
    /// Adds sums over the squares that a row of cubes has in plane k of cells.
    void add_row(int k, int row, std::span<double> scratch, std::span<double> sum) const;

    Communicator comm_;
    const Threads& threads_;
    const FlowPlanes& flow_;
    CellBox box_;
    Slab slab_, planes_;
    CellField field_ = CellField::velocity;
    std::vector<double> from_below_; ///< sums of the first plane of cubes over each plane of cells of ranks below
};

class BlockSampler {
public:
    BlockSampler(const Communicator& comm, const Threads& threads, const FlowPlanes& flow, int edge);

    /// Finds the blocks in which the magnitude of a field exceeds a threshold. Collective.
    void find(CellField criterion, double threshold);
    /// First cells of these blocks over `edge`, ordered by z, y, x. All ranks have all blocks.
    const std::vector<std::array<int, 3>>& blocks() const { return blocks_; }
    /// Planes of this rank in `count` blocks from `first` on.
    struct Piece {
        std::size_t first, count;
        int plane, planes; ///< first plane in the blocks, and their number
    };
    /// Pieces of at most `most_numbers` numbers, unless a block's share has more.
    std::vector<Piece> pieces(std::size_t most_numbers) const;
    /// Writes a piece, [block][plane][row][cell][component], with NaN beyond the grid.
    void sample(CellField field, const Piece& piece, std::span<double> out) const;

private:
    /// Number of cells of a block along a direction.
    int extent(int direction, int block) const;

    Communicator comm_;
    const Threads& threads_;
    const FlowPlanes& flow_;
    int edge_;
    std::array<int, 3> cells_, counts_; ///< numbers of cells and of blocks
    std::vector<std::array<int, 3>> blocks_;
};

} // namespace skein
