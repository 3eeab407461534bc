// Drag of a thin rod in a viscous fluid at rest, to leading order in 1/ln(L/r), without a flow solver. theory.md (38)
//   F_k = -4 pi mu l'/ln(L'/r) (1 - t t^T/2) v_k,  half to each node of element k        [N] lab
//   l', t: present length and tangent; L' = sum of l'; r = sqrt(V/(pi l'));
//   v_k = (m_k v_k + m_{k+1} v_{k+1})/(m_k + m_{k+1})
// Source: Cox 1970 (J. Fluid Mech. 44, 791), Gazzola et al. 2018. The velocity is that before the kick, so this
// explicit load is of first order in the step. It is stable only while (step) x (drag rate) < 2, which the plan counts
// among the limits. Damping of kind "physical" has neither fault. In a ring node n is node 0. Cost: 100 flop per
// element, of them 45 for the logarithm, with a square root and two divisions.
#pragma once

#include "core/logarithm.hpp"
#include "skein/core/fields.hpp"
#include "skein/core/index.hpp"
#include "skein/loads/load.hpp"
#include "skein/tiles/mapping.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace skein {

struct SlenderBodyDrag {
    static constexpr std::string_view kind = "slender_body_drag", label = "slender-body drag";
    static constexpr bool for_rigid_bodies = false;
    double viscosity = 0; ///< mu, Pa s

    void fields(FieldVisitor& f) {
        f.visit({.name = "viscosity",
                 .unit = "Pa s",
                 .text = "viscosity of the fluid, which is at rest; the rate of this explicit load limits the step",
                 .required = true,
                 .above = 0},
                viscosity);
    }
    void check(RodSpecs groups, Objections& objections) const {
        for (const RodSpec* rods : groups)
            if (rods->shape.length <= std::max(rods->section.radius, rods->section.radius_2))
                objections.add("", "slender_body_drag is for slender rods: those of group '" + rods->name +
                                       "' are not longer than their radius");
    }

    /// Constants of an element.
    template <class N> struct Row {
        N share;  ///< m_k/(m_k + m_{k+1})
        N thread; ///< pi/V, 1/m^3
    };
    std::vector<Row<double>> rows; ///< [n]

    static constexpr bool tables_by_lane = true;
    void bind_group(const RodGroup& group) { rows = rows_of(group); }
    static std::vector<Row<double>> rows_of(const RodGroup& group) {
        std::vector<Row<double>> rows;
        for (int k = 0; k < group.elements(); ++k)
            rows.push_back({mass(group, k) / (mass(group, k) + mass(group, k + 1)),
                            std::numbers::pi / nth(group.element, k).volume});
        return rows;
    }

    /// Largest decay rate of a velocity at the rest lengths. Its upper bound is the sum along a node's row: half of the
    /// drag of both its elements over its mass. theory.md (38)
    DragRate largest_rate(const RodGroup& group) const {
        const int n = group.elements();
        const auto half_drag = [&](int k) {
            const ElementConstants& e = nth(group.element, k);
            return 2 * std::numbers::pi * viscosity * e.rest_length / std::log(group.spec().shape.length / e.radius);
        };
        DragRate largest;
        for (int i = 0; i <= n; ++i) {
            double drag = 0;
            if (const int before = group.element_before(i); before >= 0) drag += half_drag(before);
            if (const int after = group.element_after(i); after >= 0) drag += half_drag(after);
            const double rate = drag / mass(group, i);
            if (rate > largest.value) largest = {rate, std::min(i, n - 1)};
        }
        return largest;
    }

    static constexpr bool data_along_only = true;
    /// Data of a tile along: constants by lane, and present lengths, which are added up along each rod in its own
    /// order.
    template <int W> struct TileData {
        LaneRows<Row<Pack<W>>> rows;
        mutable AlignedVector<Pack<W>> length;
    };
    template <int W> TileData<W> bind(const RodTile<W>& rod) const {
        return {in_lanes<Row>(rod, rows_of), AlignedVector<Pack<W>>(rod.strands ? to_index(rod.n) : 0)};
    }

    template <int W, class Map = Across<W>>
    void add(const RodTile<W>& rod, const TileData<W>& data, SlotLoad<W>* load, const Step&) const {
        using P = Pack<W>;
        const P total = total_length<Map>(rod, data);
        const Vec3<P> last_velocity = last_node_value<Map>(rod, rod.slot[0].velocity, rod.slot[rod.n].velocity);
        const auto half_drag = [&](int k) __attribute__((always_inline)) {
            const auto& c = Map::row(rows, data.rows, k);
            const Vec3<P> edge = edge_of(rod, k);
            const P squared = dot(edge, edge), length = sqrt(squared);
            const Vec3<P>& next = k + 1 < rod.n ? rod.slot[k + 1].velocity : last_velocity;
            const Vec3<P> v = fma(P(c.share), rod.slot[k].velocity, P(1 - c.share) * next);
            const P slender = P(0.5) * log(total * total * length * P(c.thread)); // ln(L'/r) = ln(L'^2/r^2)/2
            const P inverse = P(1.0) / (squared * slender);                       // one division for two inverses
            const Vec3<P> transverse = v - (P(0.5) * dot(edge, v) * slender * inverse) * edge;
            return where_present<Map>(rod, k,
                                      (P(-2 * std::numbers::pi * viscosity) * length * squared * inverse) * transverse);
        };
        const Vec3<P> last = half_drag(rod.n - 1);
        Vec3<P> before = first_node_value<Map>(rod, last);
        for (int k = 0; k + 1 < rod.n; ++k) {
            const Vec3<P> half = half_drag(k);
            load[k].force = load[k].force + before + half;
            before = half;
        }
        load[rod.n - 1].force = load[rod.n - 1].force + before + last;
        load[rod.n].force += last;
    }

private:
    template <int W> SKEIN_INLINE static Vec3<Pack<W>> edge_of(const RodTile<W>& rod, int k) {
        return rod.slot[k + 1].position - rod.slot[k].position;
    }
    /// L' of the rod of every lane, m.
    template <class Map, int W> static Pack<W> total_length(const RodTile<W>& rod, const TileData<W>& data) {
        Pack<W> total(0.0);
        if constexpr (Map::along) {
            for (int k = 0; k < rod.n; ++k) nth(data.length, k) = norm(edge_of(rod, k));
            for (const LaneRange& range : rod.strands->ranges()) {
                double sum = 0;
                for (int l = range.lane, left = range.group->elements(); left > 0; ++l, left -= rod.n)
                    for (std::size_t k = 0; k < to_index(std::min(left, rod.n)); ++k) sum += data.length[k][l];
                for (int l = range.lane; l < range.lane + range.lanes; ++l) total.set(l, sum);
            }
        } else {
            for (int k = 0; k < rod.n; ++k) total = total + norm(edge_of(rod, k));
        }
        return total;
    }
    static double mass(const RodGroup& group, int i) {
        return nth(group.node_mass, group.closed() ? i % group.elements() : i);
    }
};

} // namespace skein
