// Mappings of rods to the lanes of a tile. A pass takes the mapping as a template argument, which finds the constants
// of a lane.
//   Across    a rod per lane, all of one group: constants are numbers, the same in all lanes
//   Along     strands (tiles/strands.hpp): constants are packs
// Physics is written once for both, and gives the same bits.
#pragma once

#include "skein/core/index.hpp"
#include "skein/tiles/tile.hpp"

#include <algorithm>
#include <concepts>
#include <vector>

namespace skein {

template <int W> struct Across {
    static constexpr bool along = false;
    SKEIN_INLINE static const ElementConstants& element(const RodTile<W>& rod, int k) { return rod.element[k]; }
    SKEIN_INLINE static const VoronoiConstants& cell(const RodTile<W>& rod, int k) { return rod.voronoi[k]; }
    SKEIN_INLINE static double node_mass(const RodTile<W>& rod, int i) { return nth(rod.group->node_mass, i); }
    SKEIN_INLINE static double node_length(const RodTile<W>& rod, int i) { return nth(rod.group->node_length, i); }
    static double length(const RodTile<W>& rod) { return rod.group->spec().shape.length; }
    static double density(const RodTile<W>& rod) { return rod.group->spec().material.density; }
    static double nodal_density(const RodTile<W>& rod) { return rod.group->nodal_density; }
    /// Row k of a table by element: numbers of the group.
    template <class Row, class LaneRow>
    SKEIN_INLINE static const Row& row(const std::vector<Row>& of_group, const LaneRows<LaneRow>&, int k) {
        return nth(of_group, k);
    }

    /// Adds forces to the first and last nodes of the tile's rods.
    static void add_to_ends(const RodTile<W>& rod, SlotLoad<W>* load, const Vec3d& start, const Vec3d& end) {
        load[0].force += broadcast<W>(start);
        load[rod.n].force += broadcast<W>(end);
    }
};

template <int W> struct Along {
    static constexpr bool along = true;
    SKEIN_INLINE static const auto& element(const RodTile<W>& rod, int k) { return rod.strands->element[k]; }
    SKEIN_INLINE static const auto& cell(const RodTile<W>& rod, int k) { return rod.strands->cell[k]; }
    SKEIN_INLINE static Pack<W> node_mass(const RodTile<W>& rod, int i) { return rod.strands->node[i].mass; }
    SKEIN_INLINE static Pack<W> node_length(const RodTile<W>& rod, int i) { return rod.strands->node[i].length; }
    static Pack<W> length(const RodTile<W>& rod) { return rod.strands->length; }
    static Pack<W> density(const RodTile<W>& rod) { return rod.strands->density; }
    static Pack<W> nodal_density(const RodTile<W>& rod) { return rod.strands->nodal_density; }
    /// Row k of a table by element: packs of the tile, see in_lanes.
    template <class Row, class LaneRow>
    SKEIN_INLINE static const LaneRow& row(const std::vector<Row>&, const LaneRows<LaneRow>& of_tile, int k) {
        return of_tile[k];
    }

    static void add_to_ends(const RodTile<W>& rod, SlotLoad<W>* load, const Vec3d& start, const Vec3d& end) {
        for (const LaneRange& range : rod.strands->ranges()) {
            const auto add = [&](int slot, const Vec3d& f) {
                const auto [row, l] = rod.strands->place(range.lane, slot);
                set_lane(load[row].force, l, lane(load[row].force, l) + f);
            };
            add(0, start);
            add(range.group->elements(), end);
        }
    }
};

/// Strain nu = Q dx/l0 of an element; rest strain where there is none.
template <class Map, int W> SKEIN_INLINE Vec3<Pack<W>> element_strain(const RodTile<W>& rod, int k) {
    const auto& c = Map::element(rod, k);
    Vec3<Pack<W>> nu =
        Pack<W>(c.inv_rest_length) * (rod.slot[k].director * (rod.slot[k + 1].position - rod.slot[k].position));
    if constexpr (Map::along) nu.z += c.absent;
    return nu;
}

/// Frame of element `next` beside element k; that of element k where there is no cell between them.
template <class Map, int W> SKEIN_INLINE decltype(auto) neighbour_frame(const RodTile<W>& rod, int k, int next) {
    const Quaternion<Pack<W>>& q = rod.slot[next].director;
    if constexpr (Map::along) return select(Map::cell(rod, k).present, q, rod.slot[k].director);
    else return (q);
}

/// Table of a load by element, in the lanes of a tile along, with 0 where there is no element; empty for a tile across.
/// `of_rod(group)`: that of a rod with these constants.
template <template <class> class Row, int W, class OfRod>
requires std::invocable<OfRod, const RodGroup&> LaneRows<Row<Pack<W>>> in_lanes(const RodTile<W>& rod, OfRod&& of_rod) {
    LaneRows<Row<Pack<W>>> rows;
    if (!rod.strands) return rows;
    std::vector<std::vector<Row<double>>> of_range;
    int range_of[lanes_of<W>];
    std::fill_n(range_of, lanes_of<W>, 0);
    for (const LaneRange& range : rod.strands->ranges()) {
        std::fill_n(range_of + range.lane, range.lanes, static_cast<int>(of_range.size()));
        of_range.push_back(of_rod(*range.group));
    }
    for (int k = 0; k < rod.n; ++k) {
        Row<Pack<W>> row{};
        for (int i = 0; i < lanes_of<W>; ++i) {
            const int slot = rod.strands->slot(i, k);
            set_lane<Row>(row, i,
                          slot >= 0 && slot < rod.group_of(i).elements() ? nth(nth(of_range, range_of[i]), slot)
                                                                         : Row<double>{});
        }
        rows.push_back(row);
    }
    rows.close();
    return rows;
}
/// The same where all rods have one table.
template <template <class> class Row, int W>
LaneRows<Row<Pack<W>>> in_lanes(const RodTile<W>& rod, const std::vector<Row<double>>& of_group) {
    return in_lanes<Row>(rod, [&](const RodGroup&) { return of_group; });
}

/// Neutral term of sums: zeros that preserve even the sign of a zero.
template <int W> SKEIN_INLINE Vec3<Pack<W>> nothing() { return broadcast<W>(Vec3d{-0.0, -0.0, -0.0}); }

/// a where there is an element k, nothing() elsewhere.
template <class Map, int W>
SKEIN_INLINE Vec3<Pack<W>> where_present(const RodTile<W>& rod, int k, const Vec3<Pack<W>>& a) {
    if constexpr (Map::along) return select(Map::element(rod, k).absent < Pack<W>(0.5), a, nothing<W>());
    else return a;
}

/// Value at node n of a rod: in strands that of the next lane's node 0 where the rod goes on there.
template <class Map, int W> SKEIN_INLINE Vec3<Pack<W>>
last_node_value(const RodTile<W>& rod, const Vec3<Pack<W>>& first, const Vec3<Pack<W>>& last) {
    if constexpr (Map::along) return select(rod.strands->goes_on, from_lane_after(first), last);
    else return last;
}
/// Value of element n - 1 for the first node of the next lane; nothing() where a rod begins.
template <class Map, int W> SKEIN_INLINE Vec3<Pack<W>> first_node_value(const RodTile<W>& rod, const Vec3<Pack<W>>& a) {
    if constexpr (Map::along) return select(rod.strands->first, nothing<W>(), from_lane_before(a));
    else return nothing<W>();
}

/// Copies the next lane's first slot to row n of lanes whose rod goes on there.
template <int W> void join(const RodTile<W>& rod) {
    const Slot<W>& first = rod.slot[0];
    Slot<W>& last = rod.slot[rod.n];
    const Mask<W> goes_on = rod.strands->goes_on;
    last.position = select(goes_on, from_lane_after(first.position), last.position);
    last.director = select(goes_on, from_lane_after(first.director), last.director);
}

/// Calls f.template operator()<Map>() with the tile's mapping.
template <int W, class F> decltype(auto) with_mapping(const RodTile<W>& rod, F&& f) {
    if (rod.strands) return f.template operator()<Along<W>>();
    return f.template operator()<Across<W>>();
}

} // namespace skein
