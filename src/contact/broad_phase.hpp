// Candidate pairs: elements nearer to each other than their radii and a skin.
// A grid per size of elements, each twice as coarse as the one before; an element looks into its own grid and all coarser ones. Cells
// wrap round, so space has no bounds. The grids are built by counting, all threads at once; within a cell elements are put in order, so
// that the list is the same for any number of threads.
// Cost per element at nest density: see docs/performance.md.
#pragma once

#include "contact/capsules.hpp"
#include "parallel/threads.hpp"

#include <cmath>
#include <span>

namespace skein {

struct Pair {
    std::uint32_t a, b; ///< slots
    friend auto operator<=>(const Pair&, const Pair&) = default;
};

/// Pairs by their first element: partners[first[a]] .. partners[first[a + 1] - 1], in rising order. Of two elements of one size the
/// first is the one with the lower slot, of others the smaller.
struct Candidates {
    std::vector<std::uint32_t> first; ///< [slots + 1]
    std::vector<std::uint32_t> partner;

    std::size_t count() const { return partner.size(); }
    std::span<const std::uint32_t> of(std::size_t a) const { return {partner.data() + first[a], partner.data() + first[a + 1]}; }
};

class BroadPhase {
public:
    /// Sizes are those at this time, and stay elements' own: stretch changes cells, not grids. The largest element of a grid is at most
    /// twice its smallest.
    BroadPhase(const Capsules& capsules, const Threads& threads);
    ~BroadPhase();

    /// All pairs whose capsules are less than `skin` apart, m, and that may touch.
    void build(const Capsules& capsules, double skin, Candidates& candidates);

    /// The same by looking at every pair: what `build` is held against.
    static void build_exhaustively(const Capsules& capsules, double skin, const BroadPhase& sizes, Candidates& candidates);

    int grids() const { return static_cast<int>(grids_.size()); }

private:
    struct Grid {
        float cells_per_metre = 0;
        std::uint32_t size[3] = {4, 4, 4}; ///< powers of two
        std::uint32_t first_cell = 0;      ///< in cell_begin_
        std::uint32_t cells() const { return size[0] * size[1] * size[2]; }
    };
    struct Block;
    class Neighbourhood;
    bool comes_first(std::uint32_t a, std::uint32_t b) const { return grid_of_[a] != grid_of_[b] ? grid_of_[a] < grid_of_[b] : a < b; }
    static std::uint32_t cell_at(const Grid& grid, float x) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(x * grid.cells_per_metre))); }
    void size_grids(const Capsules& capsules, double skin);
    void fill_grids(const Capsules& capsules);
    void collect(const Grid& grid, const std::uint32_t (&cell)[3], Neighbourhood& near) const;
    void look(const Capsules& capsules, double skin, const Grid& grid, std::uint32_t begin, std::uint32_t end, Block& block) const;

    const Threads& threads_;
    std::vector<std::uint8_t> grid_of_; ///< of each slot
    std::vector<Grid> grids_;
    Vec3d origin_{0, 0, 0};
    float slack_ = 0; ///< what single precision may lose, m
    // Elements by cell, as spheres about their middles; one array per component, as vector instructions want them.
    AlignedVector<float> x_, y_, z_, reach_;
    std::vector<std::uint32_t> slot_;
    std::vector<std::uint32_t> cell_of_, cell_begin_;
    std::vector<Block> blocks_;
};

} // namespace skein
