// Candidate pairs: elements nearer to each other than their radii and a skin.
//   1. spheres round the elements, in single precision, sorted into cells by counting
//   2. each sphere against those of half its neighbouring cells, sixteen at a time
//   3. capsules against capsules where spheres overlap, eight pairs at a time
// Each size of elements has a grid, twice as coarse as the one before. An element searches its own grid and all coarser
// ones. Cells wrap round, so space has no bounds. Pairs are sorted at the end, so any number of threads finds the same
// list. docs/performance.md gives the cost per element at nest density.
#pragma once

#include "neighbourhood/exposure.hpp"
#include "parallel/threads.hpp"
#include "skein/core/index.hpp"

#include <span>

namespace skein {

/// Two elements, by their slots.
struct Pair {
    std::uint32_t a, b;
    friend auto operator<=>(const Pair&, const Pair&) = default;
};

/// Rule for elements of one body: numbers must differ by more than `elements`, in a ring both ways round.
struct SelfGap {
    std::int32_t elements = -1; ///< below 0: none may
    std::int32_t ring = 0;      ///< elements of a ring, the last of which joins the first; 0: not a ring

    bool touches_itself() const { return elements >= 0; }
    bool may_touch(std::int32_t a, std::int32_t b) const {
        const std::int32_t apart = a < b ? b - a : a - b, other_way = ring > 0 ? ring - apart : apart;
        return touches_itself() && apart > elements && other_way > elements;
    }
};
using SelfGaps = std::vector<SelfGap>; ///< by group

/// True where two elements may touch, wherever they are.
inline bool may_touch(const Exposure& c, const SelfGaps& gaps, std::uint32_t a, std::uint32_t b) {
    if (c.window_of[a] != c.window_of[b])
        return c.kin_of(a) != c.kin_of(b); // bodies differ, even where both are ghosts, as a body has one owner
    return nth(gaps, c.at(a).group).may_touch(static_cast<std::int32_t>(a), static_cast<std::int32_t>(b));
}

/// Pairs by their first element, which is that with the lower slot: partner[first[a]] .. partner[first[a + 1] - 1], in
/// rising order.
struct Candidates {
    std::vector<std::uint32_t> first; ///< [slots + 1]
    std::vector<std::uint32_t> partner;
    std::int64_t inactive = 0; ///< pairs that are near and do not touch, of those whose first element is of an own body

    std::size_t count() const { return partner.size(); }
};

class BroadPhase {
public:
    explicit BroadPhase(const Threads& threads);
    ~BroadPhase();

    /// All pairs whose capsules are less than `skin` apart, m, that may touch, and of which one is of an own body. The
    /// largest element of a grid is at most twice its smallest.
    void build(const Exposure& bodies, const SelfGaps& gaps, double skin, Candidates& candidates);

    /// Forgets the sizes of the first search, as the bodies have changed.
    void forget_sizes() { smallest_ = 0; }

    /// Exhaustive search over every pair, for tests of `build`.
    static void build_exhaustively(const Exposure& bodies, const SelfGaps& gaps, double skin, Candidates& candidates);

    int grids() const { return static_cast<int>(grids_.size()); }

private:
    struct Grid {
        float cells_per_metre = 0;
        std::uint32_t size[3] = {4, 4, 4}; ///< powers of two
        std::uint32_t first_cell = 0;      ///< in cell_begin_
        std::uint32_t cells() const { return size[0] * size[1] * size[2]; }
        std::uint32_t cell_at(float x) const;
    };
    /// In cells' order: begin and behind.
    struct Range {
        std::uint32_t begin, end;
    };
    struct Sphere {
        float x, y, z; ///< from origin_, m
        float reach;   ///< m
    };
    /// Elements side by side, as vector instructions want them.
    struct Spheres {
        const float *x, *y, *z, *reach;
        const std::int32_t* body;
        const std::uint32_t* slot;
    };
    struct Ranges;
    struct Copies;
    struct Found;
    Spheres spheres() const { return {x_.data(), y_.data(), z_.data(), reach_.data(), body_.data(), slot_.data()}; }
    void find_sizes(const Exposure& bodies);
    struct Extent;
    Extent set_spheres(const Exposure& bodies);
    void size_grids(const Extent& all, double skin);
    void measure(const Exposure& bodies, double skin);
    void fill_grids(const Exposure& bodies, const SelfGaps& gaps);
    void add_row(const Grid& grid, std::uint32_t x, std::uint32_t y, std::uint32_t z, Ranges& ranges) const;
    void search_cells(const Grid& grid, std::uint32_t begin, std::uint32_t end, float margin, Found& found) const;
    void collect_overlaps(std::uint32_t i, const Spheres& others, Range range, float margin, Found& found) const;

    const Threads& threads_;
    double smallest_ = 0; ///< element of the first search of these bodies, m: half its length and its radius
    std::vector<std::uint8_t> grid_of_; ///< grid, by slot
    std::vector<Grid> grids_;
    Vec3d origin_{0, 0, 0}, next_origin_{0, 0, 0};
    float slack_ = 0;              ///< loss of single precision, m
    AlignedVector<Sphere> sphere_; ///< by slot
    // By cell.
    AlignedVector<float> x_, y_, z_, reach_;
    AlignedVector<std::int32_t>
        body_; ///< elements with the same one do not touch: Exposure::kin_of, or slots where a body touches itself
    AlignedVector<std::uint32_t> slot_;
    std::vector<std::uint32_t> cell_of_, place_, cell_begin_;
    struct Near {
        std::vector<Pair> pairs;
        std::int64_t inactive = 0;
    };
    std::vector<Near> near_; ///< by task
    static void append_near(const Exposure& bodies, const SelfGaps& gaps, double skin, std::uint32_t* a,
                            std::uint32_t* b, std::size_t count, Near& near);
};

} // namespace skein
