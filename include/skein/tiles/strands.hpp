// Mapping along the rod: lanes of a tile carry strands. A strand is a rod, or one of the equal pieces of a rod. A lone
// rod thus fills all lanes, and rods of other lengths and groups lie beside it.
//   row       0           1           ...   m - 1             m
//   lane j    slot j m    slot j m+1  ...   slot (j+1) m - 1  the next lane's row 0, where the rod goes on there
// Constants differ from lane to lane. Slots after a rod's last node are absent: without stiffness, of infinite mass, at
// rest strain. The last node's slot has no element; its frame is that of the wall of a clamped end.
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <span>

namespace skein {

/// One row per slot of a strand. Equal rows are stored once: those of uniform rods stay in the first cache.
template <class Row> class LaneRows {
public:
    LaneRows() = default;
    LaneRows(LaneRows&&) = default; // its pointers point into itself, so that it cannot be copied
    LaneRows& operator=(LaneRows&&) = default;
    void push_back(const Row& row) {
        std::size_t at = distinct_.size();
        while (at > 0 && std::memcmp(&distinct_[at - 1], &row, sizeof row) != 0) --at;
        if (at == 0) {
            distinct_.push_back(row);
            at = distinct_.size();
        }
        which_.push_back(at - 1);
    }
    /// Room for rows of which none are equal.
    void reserve(int rows) { distinct_.reserve(to_index(rows)); }
    /// Ends the list of rows, which may be read from now on.
    void close() {
        row_.clear();
        row_.reserve(which_.size());
        for (const std::size_t i : which_) row_.push_back(&distinct_[i]);
        which_ = {};
    }
    SKEIN_INLINE const Row& operator[](int k) const { return *nth(row_, k); }
    std::size_t bytes() const { return distinct_.size() * sizeof(Row) + row_.size() * sizeof(const Row*); }

private:
    AlignedVector<Row> distinct_;
    std::vector<std::size_t> which_;
    std::vector<const Row*> row_;
};

/// Sets one lane of a structure of packs to the numbers of a structure with the same members.
template <template <class> class Constants, int W>
void set_lane(Constants<Pack<W>>& all, int l, const Constants<double>& one) {
    constexpr std::size_t count = sizeof one / sizeof(double);
    static_assert(count == sizeof all / sizeof(Pack<W>));
    const auto* from = reinterpret_cast<const double*>(&one);
    if constexpr (sizeof(Pack<W>) == lanes_of<W> * sizeof(double)) { // a pack lies in memory as its lanes
        auto* to = reinterpret_cast<double*>(&all) + l;
        for (std::size_t i = 0; i < count; ++i) to[i * lanes_of<W>] = from[i];
    } else {
        auto* packs = reinterpret_cast<Pack<W>*>(&all);
        for (std::size_t i = 0; i < count; ++i) packs[i].set(l, from[i]);
    }
}

/// Place of a rod in a tile along.
struct LaneRange {
    const RodGroup* group;
    std::int64_t index; ///< number in its group
    int lane, lanes;    ///< lane of its first piece, and number of pieces
};

template <int W> class Strands {
public:
    using P = Pack<W>;
    struct Element : ElementConstantsOf<P> {
        P absent; ///< 1 where there is no element
    };
    struct Cell : VoronoiConstantsOf<P> {
        Mask<W> present; ///< lanes with a cell, between two elements or an element and a wall
        Mask<W> inner;   ///< lanes with a cell between two elements
    };
    struct Node {
        P mass, length; ///< RodGroup::node_mass, node_length; 0 where there is none
    };

    Strands(std::span<const LaneRange> ranges, int rows);

    int rows() const { return rows_; }
    std::span<const LaneRange> ranges() const { return ranges_; }
    /// Slot of its rod that a lane has in a row, or -1. Row `rows()` has a slot only where the rod does not go on.
    int slot(int l, int row) const;
    /// Group of the rod in a lane; an empty lane takes the first.
    const RodGroup& group(int l) const { return *range(l).group; }
    std::int64_t index(int l) const { return range(l).index; }

    /// Sets the group of all lanes. Rods of heterogeneous groups are laid out with groups of their own, whose constants
    /// are copied.
    void settle(const RodGroup& group) {
        for (LaneRange& range : ranges_) range.group = &group;
    }

    /// Sets the group of each rod; f(index) for its number.
    template <class F> void settle_each(F&& f) {
        for (LaneRange& range : ranges_) range.group = &f(range.index);
    }

    /// Place of a slot of the rod in this lane.
    struct Place {
        int row, lane;
    };
    Place place(int l, int k) const {
        const int piece = std::min(k / rows_, range(l).lanes - 1);
        return {k - piece * rows_, range(l).lane + piece};
    }

    LaneRows<Element> element;        ///< [rows]
    LaneRows<Cell> cell;              ///< [rows]: between a row and the next
    LaneRows<Node> node;              ///< [rows + 1]
    Mask<W> first;                    ///< lanes where a rod begins
    Mask<W> goes_on;                  ///< lanes whose rod goes on in the next
    P length, density, nodal_density; ///< m, kg/m^3, by lane
    bool start_walls = false;         ///< true where some of the rods have a half cell before them
    Mask<W> start_wall;
    Quaternion<P> start_frame;
    VoronoiConstantsOf<P> start_cell; ///< constants of these half cells

    std::size_t bytes() const {
        return sizeof *this + element.bytes() + cell.bytes() + node.bytes() + ranges_.size() * sizeof(LaneRange);
    }

private:
    void find_ends();
    void add_row(int row);
    const LaneRange& range(int l) const { return nth(ranges_, std::max(0, range_[l])); }

    std::vector<LaneRange> ranges_;
    int rows_;
    int range_[lanes_of<W>]; ///< range of every lane; -1 where it is empty
};

/// Harmless numbers for absent slots, from an element that exists.
inline ElementConstants absent_element(ElementConstants c) {
    c.inv_rest_length = 0;
    c.stiffness = c.rest_strain = c.bending = {0, 0, 0};
    c.rest_stretch = 1;
    return c;
}

template <int W> int Strands<W>::slot(int l, int row) const {
    if (range_[l] < 0) return -1;
    const LaneRange& range = nth(ranges_, range_[l]);
    const int piece = l - range.lane, at = piece * rows_ + row;
    if (row == rows_ && piece + 1 < range.lanes) return -1;
    return at <= range.group->elements() ? at : -1;
}

template <int W> Strands<W>::Strands(std::span<const LaneRange> ranges, int rows)
    : ranges_(ranges.begin(), ranges.end()), rows_(rows) {
    std::fill(range_, range_ + W, -1);
    for (std::size_t s = 0; s < ranges_.size(); ++s)
        for (int piece = 0; piece < ranges_[s].lanes; ++piece) range_[ranges_[s].lane + piece] = static_cast<int>(s);
    find_ends();
    if (ranges_.front().group->single_rod()) {
        element.reserve(rows_);
        cell.reserve(rows_);
        node.reserve(rows_ + 1);
    }
    for (int row = 0; row <= rows_; ++row) add_row(row);
    element.close();
    cell.close();
    node.close();
}

template <int W> void Strands<W>::find_ends() {
    const auto mask = [](auto holds) {
        P one(0.0);
        for (int i = 0; i < lanes_of<W>; ++i) one.set(i, holds(i) ? 1 : 0);
        return one > P(0.0);
    };
    const auto begins = [&](int i) { return range_[i] < 0 || range(i).lane == i; };
    first = mask(begins);
    goes_on = mask([&](int i) { return range_[i] >= 0 && i + 1 < range(i).lane + range(i).lanes; });
    start_wall =
        mask([&](int i) { return range_[i] >= 0 && begins(i) && range(i).group->spec().start == EndKind::clamped; });
    start_walls = any(start_wall);
    for (int i = 0; i < lanes_of<W>; ++i) {
        const RodGroup& group = *range(i).group;
        length.set(i, group.spec().shape.length);
        density.set(i, group.spec().material.density);
        nodal_density.set(i, group.nodal_density);
        set_lane(start_frame, i, group.frame(range(i).index));
        set_lane<VoronoiConstantsOf>(start_cell, i, group.start_wall);
    }
}

template <int W> void Strands<W>::add_row(int row) {
    Element e{};
    Cell c{};
    Node n{};
    P present(0.0), inner(0.0);
    for (int i = 0; i < lanes_of<W>; ++i) {
        const RodGroup& group = *range(i).group;
        const int k = slot(i, row), elements = group.elements();
        const bool has_element = k >= 0 && k < elements,
                   clamped_end = k == elements - 1 && group.spec().end == EndKind::clamped;
        const ElementConstants& own = nth(group.element, has_element ? k : 0);
        set_lane<ElementConstantsOf>(e, i, has_element ? own : absent_element(own));
        e.absent.set(i, has_element ? 0 : 1);
        const bool has_next = has_element && k < elements - 1;
        if (has_next) set_lane<VoronoiConstantsOf>(c, i, nth(group.voronoi, k));
        else if (clamped_end) set_lane<VoronoiConstantsOf>(c, i, group.end_wall);
        else set_lane<VoronoiConstantsOf>(c, i, {0, 1, 0, {0, 0, 0}, {0, 0, 0}});
        present.set(i, has_next || clamped_end ? 1 : 0);
        inner.set(i, has_next ? 1 : 0);
        n.mass.set(i, k >= 0 ? nth(group.node_mass, k) : 0);
        n.length.set(i, k >= 0 ? nth(group.node_length, k) : 0);
    }
    c.present = present > P(0.0);
    c.inner = inner > P(0.0);
    if (row < rows_) {
        element.push_back(e);
        cell.push_back(c);
    }
    node.push_back(n);
}

} // namespace skein
