// Points of a group's rods that touch walls, as balls, and what a force and a couple there do to the rod.
#pragma once

#include "contact/implicit_walls.hpp"
#include "contact/response.hpp"
#include "contact/tangent_lanes.hpp"
#include "rod/body_shape.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/mapping.hpp"
#include "skein/tiles/tile.hpp"

#include <algorithm>
#include <type_traits>

namespace skein {

/// Number of points of one rod: its nodes, or the points of a body's surface.
inline std::size_t wall_points(const RodGroup& group) {
    return group.strained() ? to_index(group.slots()) : group.body()->point.size();
}

/// Adds in some lanes only. Adding 0 elsewhere would turn -0 into 0, and other lanes decide whether this is reached.
template <int W> SKEIN_INLINE void add_where(const Mask<W>& lanes, Pack<W>& to, const Pack<W>& more) {
    to = select(lanes, to + more, to);
}
template <int W> SKEIN_INLINE void add_where(const Mask<W>& lanes, Vec3<Pack<W>>& to, const Vec3<Pack<W>>& more) {
    to = select(lanes, to + more, to);
}

/// Slopes of a point's contact: unit vector n, p, q and arm r of slot_tangent.hpp; 0 in lanes that touch nothing.
template <int W> struct PointSlopes {
    Vec3<Pack<W>> normal;
    Pack<W> along, across, arm;
};

namespace detail {

/// Adds [a] S, with a from the left or, with its sign turned, from the right: columns a x S, lines a x S.
template <class P> SKEIN_INLINE void add_levered(P (&to)[3][3], const Vec3<P>& a, const P (&s)[3][3]) {
    for (int j = 0; j < 3; ++j) {
        const Vec3<P> column = cross(a, Vec3<P>{s[0][j], s[1][j], s[2][j]});
        to[0][j] += column.x;
        to[1][j] += column.y;
        to[2][j] += column.z;
    }
}
template <class P> SKEIN_INLINE void add_by_lever(P (&to)[3][3], const P (&s)[3][3], const Vec3<P>& a) {
    for (int i = 0; i < 3; ++i) {
        const Vec3<P> line = cross(a, Vec3<P>{s[i][0], s[i][1], s[i][2]});
        to[i][0] += line.x;
        to[i][1] += line.y;
        to[i][2] += line.z;
    }
}

} // namespace detail

/// Nodes, with the mean of their elements' radii at rest and of their lab spins; half of a couple goes to each of these
/// elements.
template <int W, class Map = Across<W>> class RodNodes {
public:
    using P = Pack<W>;
    static constexpr bool lies_across = std::is_same_v<Map, Across<W>>;
    explicit RodNodes(const RodGroup& group) {
        for_each_kind(group, [&](const RodGroup& kind, double) {
            for (const ElementConstants& e : kind.element) largest_radius_ = std::max(largest_radius_, e.radius);
        });
    }
    double largest_radius() const { return largest_radius_; }
    int count(const RodTile<W>& rod) const { return rod.group->closed() ? rod.n : rod.n + 1; }
    auto mass(const RodTile<W>& rod, int i) const { return Map::node_mass(rod, i); }
    SKEIN_INLINE const Vec3<P>& position(const RodTile<W>& rod, int i) const { return rod.slot[i].position; }

    auto radius(const RodTile<W>& rod, int i) const {
        const auto [before, after] = around(rod, i);
        using R = std::decay_t<decltype(Map::element(rod, before).radius)>;
        return R(0.5) * (Map::element(rod, before).radius + Map::element(rod, after).radius);
    }

    /// Their rates, for the law of contact.
    SKEIN_INLINE void describe(const RodTile<W>& rod, int i, ContactState<P>& state) const {
        const auto [before, after] = around(rod, i);
        const Slot<W>&one = rod.slot[before], &other = rod.slot[after];
        state.velocity_1 = rod.slot[i].velocity;
        state.spin_1 = P(0.5) * (transpose_times(one.director, one.spin) + transpose_times(other.director, other.spin));
    }
    /// Axis of the rod at a node: the sum of its elements' tangents.
    SKEIN_INLINE Vec3<P> axis(const RodTile<W>& rod, int i) const {
        const auto [before, after] = around(rod, i);
        return third_director(rod.slot[before].director) + third_director(rod.slot[after].director);
    }
    /// A force and a couple in the lab, on the rods of these lanes.
    SKEIN_INLINE void push(const RodTile<W>& rod, SlotLoad<W>* load, int i, const Mask<W>& lanes, const Vec3<P>& force,
                           const Vec3<P>& couple) const {
        add_where(lanes, load[i].force, force);
        const auto [before, after] = around(rod, i);
        for (const int k : {before, after}) add_where(lanes, load[k].couple, P(0.5) * (rod.slot[k].director * couple));
    }
    /// Each element by itself has half of it: |x + (t + t')/2 x a|^2 <= (|x + t x a|^2 + |x + t' x a|^2)/2.
    void stiffen(const RodTile<W>& rod, typename WallTangents<W>::Tile& tangents, int i,
                 const PointSlopes<W>& of) const {
        tangents.touches = true;
        const auto [before, after] = around(rod, i);
        const P half(0.5), p = half * of.along, q = half * of.across;
        for (const bool starts : {false, true}) {
            const int k = starts ? after : before;
            const double share = before != after ? (starts ? 0.0 : 1.0) : (i == 0 ? 0.0 : 1.0);
            tangents.element[to_index(k)].add(of.normal, p, q, share, of.arm);
        }
    }
    /// Slopes S of the force by the displacement of the contact at `lever` from the node: it goes with x + t x a.
    void add_slopes(const RodTile<W>&, WallSlopes<W>& to, int i, const P (&s)[3][3], const Vec3<P>& lever,
                    const Vec3<P>&) const {
        to.touches = true;
        auto& point = to.point[to_index(i)];
        P by_turn[3][3]{};
        detail::add_by_lever(by_turn, s, lever);
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) {
                point.force[r][c] += s[r][c];
                point.force_by_turn[r][c] += by_turn[r][c];
            }
        detail::add_levered(point.couple, lever, s);
        detail::add_levered(point.couple_by_turn, lever, by_turn);
    }

private:
    /// At an end both are the one element there.
    static std::pair<int, int> around(const RodTile<W>& rod, int i) {
        return {i > 0 ? i - 1 : rod.group->closed() ? rod.n - 1 : 0, i < rod.n ? i : rod.n - 1};
    }
    double largest_radius_ = 0;
};

/// Points of a body's surface.
template <int W> class SurfacePoints {
public:
    using P = Pack<W>;
    static constexpr bool lies_across = true;
    explicit SurfacePoints(const RodGroup& group) : body_(*group.body()) {
        for (const BodyShape::Point& p : body_.point) largest_radius_ = std::max(largest_radius_, p.radius);
    }
    double largest_radius() const { return largest_radius_; }
    int count(const RodTile<W>&) const { return static_cast<int>(body_.point.size()); }
    double mass(const RodTile<W>& rod, int) const { return rod.group->node_mass.front(); }
    SKEIN_INLINE Vec3<P> position(const RodTile<W>& rod, int i) const {
        return rod.slot[0].position + transpose_times(rod.slot[0].director, place(i));
    }

    double radius(const RodTile<W>&, int i) const { return nth(body_.point, i).radius; }

    SKEIN_INLINE void describe(const RodTile<W>& rod, int i, ContactState<P>& state) const {
        const Slot<W>& s = rod.slot[0];
        state.velocity_1 = s.velocity + transpose_times(s.director, cross(s.spin, place(i)));
        state.spin_1 = transpose_times(s.director, s.spin);
    }
    SKEIN_INLINE Vec3<P> axis(const RodTile<W>& rod, int) const { return third_director(rod.slot[0].director); }
    SKEIN_INLINE void push(const RodTile<W>& rod, SlotLoad<W>* load, int i, const Mask<W>& lanes, const Vec3<P>& force,
                           const Vec3<P>& couple) const {
        const Quaternion<P>& q = rod.slot[0].director;
        add_where(lanes, load[0].force, force);
        add_where(lanes, load[0].couple, q * couple + cross(place(i), q * force));
    }
    /// G^T C G,  G = [1, -[a]],  a from the centre to the contact.
    void stiffen(const RodTile<W>& rod, typename WallTangents<W>::Tile& tangents, int i,
                 const PointSlopes<W>& of) const {
        tangents.touches = true;
        const Vec3<P> a = transpose_times(rod.slot[0].director, place(i)) + of.arm * of.normal;
        const P zero(0.0), one(1.0), n[3] = {of.normal.x, of.normal.y, of.normal.z};
        const P g[3][6] = {
            {one, zero, zero, zero, a.z, -a.y}, {zero, one, zero, -a.z, zero, a.x}, {zero, zero, one, a.y, -a.x, zero}};
        P c[3][6];
        for (int r = 0; r < 3; ++r)
            for (int j = 0; j < 6; ++j) {
                const P along = fma(n[0], g[0][j], fma(n[1], g[1][j], n[2] * g[2][j]));
                c[r][j] = fma((of.along - of.across) * n[r], along, of.across * g[r][j]);
            }
        for (int r = 0; r < 6; ++r)
            for (int j = 0; j < 6; ++j)
                for (int m = 0; m < 3; ++m) tangents.body[r][j] = fma(g[m][r], c[m][j], tangents.body[r][j]);
    }
    /// Slopes of a body, whose couple turns with its lever, too.
    void add_slopes(const RodTile<W>& rod, WallSlopes<W>& to, int i, const P (&s)[3][3], const Vec3<P>& lever,
                    const Vec3<P>& force) const {
        to.touches = true;
        const Vec3<P> from = transpose_times(rod.slot[0].director, place(i)), a = from + lever;
        P by_turn[3][3]{}, couple[3][3]{}, couple_by_turn[3][3]{};
        detail::add_by_lever(by_turn, s, a);
        detail::add_levered(couple, a, s);
        detail::add_levered(couple_by_turn, a, by_turn);
        const P f[3] = {force.x, force.y, force.z}, l[3] = {from.x, from.y, from.z}, along = dot(from, force);
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) {
                to.body[r][c] += s[r][c];
                to.body[r][3 + c] += by_turn[r][c];
                to.body[3 + r][c] += couple[r][c];
                to.body[3 + r][3 + c] += couple_by_turn[r][c] + l[r] * f[c] - (r == c ? along : P(0.0));
            }
        to.couple += cross(a, force);
    }

private:
    SKEIN_INLINE Vec3<P> place(int i) const { return broadcast<W>(nth(body_.point, i).place); }
    const BodyShape& body_; ///< shape of the group's bodies
    double largest_radius_ = 0;
};

} // namespace skein
