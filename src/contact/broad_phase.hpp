// Candidate pairs: elements nearer to each other than their radii and a skin.
//   1. elements, in single precision, sorted into cells by counting
//   2. box of each element against those in cells that it may reach and that come after its own, a register at a time
//   3. capsules where boxes overlap, in single precision with a margin for its rounding
//   4. capsules in double precision where these come near, eight pairs at a time
// Each size of elements has a grid, twice as coarse as the one before, and visitors from other ranks have grids of
// their own. An element searches its own grid and all coarser ones, an own one also that of visitors of its size. Cells
// wrap round, so space has no bounds. Pairs are sorted at the end, so any number of threads finds the same list.
// docs/performance.md gives the cost per element at nest density.
#pragma once

#include "contact/grouping.hpp"
#include "contact/joined_gaps.hpp"
#include "neighbourhood/exposure.hpp"
#include "parallel/threads.hpp"
#include "skein/core/index.hpp"

#include <memory>
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

/// Rules of contact: elements that may touch, wherever they are.
struct TouchRules {
    std::vector<SelfGap> of_group;            ///< of elements of one body
    std::shared_ptr<const JoinedGaps> joined; ///< of elements of one copy of an assembly; null: none may
    /// Rods with sizes of their own.
    struct OwnGaps {
        std::int64_t first_gid = 0;
        std::vector<SelfGap> of_rod;
    };
    std::vector<OwnGaps> own = {}; ///< by group; none where all have those of their group

    const SelfGap& of(const Window& w) const {
        if (own.empty() || nth(own, w.group).of_rod.empty()) return nth(of_group, w.group);
        return nth(nth(own, w.group).of_rod, w.gid - nth(own, w.group).first_gid);
    }
};

/// True where two elements may touch, wherever they are.
inline bool may_touch(const Exposure& c, const TouchRules& rules, std::uint32_t a, std::uint32_t b) {
    if (c.window_of[a] != c.window_of[b]) // bodies differ, even where both are ghosts, as a body has one owner
        return c.kin_of(a) != c.kin_of(b) || (rules.joined && rules.joined->may_touch(c, a, b));
    return rules.of(c.at(a)).may_touch(static_cast<std::int32_t>(a), static_cast<std::int32_t>(b));
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

    /// All pairs whose capsules are less than half of `skin`, m, times the paces of both apart, that may touch, and of
    /// which one is of an own body. The largest element of a grid is at most twice its smallest.
    void build(const Exposure& bodies, const TouchRules& rules, double skin, Candidates& candidates);

    /// Forgets the sizes of the first search, as the bodies have changed.
    void forget_sizes() { smallest_ = 0; }

    /// Exhaustive search over every pair, for tests of `build`.
    static void build_exhaustively(const Exposure& bodies, const TouchRules& rules, double skin,
                                   Candidates& candidates);

    /// Pairs of the last search whose capsules were tested in double precision.
    std::int64_t tested() const;

    /// Grids that have elements.
    int grids() const;

private:
    /// Elements of one size by cells at least as wide as the largest of them reaches.
    struct Grid {
        float cells_per_unit = 0;
        std::uint32_t size[3] = {8, 8, 8}; ///< powers of two, so wide that no cell is on both sides of an element
        float most[3] = {0, 0, 0};         ///< half of the largest box
        std::uint32_t first_cell = 0;      ///< in cell_begin_
        std::size_t elements = 0;
        int size_class = 0; ///< of its elements, a power of two
        bool own = true;    ///< its elements are of own bodies, else all are visitors
        std::uint32_t cells() const { return size[0] * size[1] * size[2]; }
        std::int32_t cell_at(float x) const;
        std::uint32_t row(std::int32_t y, std::int32_t z) const;
        bool searches(const Grid& other) const;
    };
    /// In cells' order: begin and behind.
    struct Range {
        std::uint32_t begin, end;
    };
    /// Cells, before they wrap round.
    struct Cells {
        std::int32_t first, last;
    };
    /// Numbers of an element: middle from origin_, half of its axis, and radius with its share of the skin, in unit_.
    static constexpr int numbers = 7;
    struct Bound {
        float number[numbers];
        float unused = 0;
    };
    /// Elements side by side, as vector instructions want them.
    struct Columns {
        const float* number[numbers]; ///< as in Bound
        const std::int32_t* body;
        const std::uint32_t* slot;
    };
    struct Ranges;
    struct Found;
    struct Element;
    struct Neighbours;
    Columns columns() const;
    bool resolves(const Exposure& bodies, std::size_t slot) const;
    void find_sizes(const Exposure& bodies);
    void set_next_origin(const Vec3d& centre);
    struct Extent;
    static std::uint8_t grid_for(int size, bool own);
    Extent set_bounds(const Exposure& bodies, double skin);
    void size_grids(const Extent& all);
    void measure(const Exposure& bodies, double skin);
    void fill_grids(const Exposure& bodies, const TouchRules& rules);
    void search_elements(const Grid& grid, Range elements, Found& found) const;
    void add_ahead(const Element& one, std::uint32_t i, const Grid& grid, Ranges& ranges) const;
    void add_around(const Element& one, const Grid& grid, Ranges& ranges) const;
    void add_row(const Grid& grid, std::uint32_t row, Cells cells, Ranges& ranges) const;
    void collect_overlaps(const Element& one, const Columns& others, const Ranges& ranges, Neighbours& near,
                          Found& found) const;
    void find_near(const Element& one, Neighbours& near, Found& found) const;

    const Threads& threads_;
    double smallest_ = 0; ///< element of the first search of these bodies, m: half its length and its radius
    static constexpr std::uint8_t no_grid = 255;
    std::vector<std::uint8_t> grid_of_; ///< grid, by slot
    std::vector<Grid> grids_;
    Vec3d origin_{0, 0, 0}, next_origin_{0, 0, 0};
    double unit_ = 1;            ///< m: that power of two below smallest_ keeps squares of squares in range
    float slack_ = 0;            ///< loss of single precision, in unit_
    AlignedVector<Bound> bound_; ///< by slot
    // By cell.
    AlignedVector<float> number_[numbers];
    AlignedVector<std::int32_t> body_; ///< elements with the same one do not touch: kin, bodies where kin may touch, or
                                       ///< slots where a body touches itself
    AlignedVector<std::uint32_t> slot_;
    std::vector<std::uint32_t> cell_of_, cell_begin_;
    Grouping cells_, pairs_;
    struct Near {
        std::vector<Pair> pairs;
        std::int64_t inactive = 0, tested = 0;
    };
    std::vector<Near> near_; ///< by task
    static void append_near(const Exposure& bodies, const TouchRules& rules, double skin, std::uint32_t* a,
                            std::uint32_t* b, std::size_t count, Near& near);
};

} // namespace skein
