// Points of a group's rods that touch walls, as balls, and what a force and a couple there do to the rod.
#pragma once

#include "contact/response.hpp"
#include "rod/body_shape.hpp"
#include "skein/rod/tile.hpp"

#include <algorithm>

namespace skein {

/// Of one rod: its nodes, or the points of a body's surface.
inline std::size_t wall_points(const RodGroup& group) {
    return group.strained() ? static_cast<std::size_t>(group.slots()) : group.body()->point.size();
}

/// Nodes, with the mean of their elements' radii at rest and of their lab spins; half of a couple goes to each of these elements.
template <int W> class RodNodes {
public:
    using P = Pack<W>;
    explicit RodNodes(const RodGroup& group) {
        for (const ElementConstants& e : group.element) largest_radius_ = std::max(largest_radius_, e.radius);
    }
    double largest_radius() const { return largest_radius_; }
    int count(const RodTile<W>& rod) const { return rod.group->closed() ? rod.n : rod.n + 1; }
    SKEIN_INLINE const Vec3<P>& position(const RodTile<W>& rod, int i) const { return rod.slot[i].position; }

    /// The element before the next node, if the node before has left it.
    struct Behind {
        int number = -1;
        P radius;
        Vec3<P> spin; ///< lab
    };
    void describe(const RodTile<W>& rod, int i, ContactState<P>& state, Behind& behind) const {
        const P half(0.5);
        const auto [before, after] = around(rod, i);
        if (behind.number != before) behind = element(rod, before);
        const Behind ahead = before == after ? behind : element(rod, after);
        state.radius_1 = half * (behind.radius + ahead.radius);
        state.velocity_1 = rod.slot[i].velocity;
        state.spin_1 = half * (behind.spin + ahead.spin);
        behind = ahead;
    }
    void push(const RodTile<W>& rod, SlotLoad<W>* load, int i, const Vec3<P>& force, const Vec3<P>& couple, Mask<W> touched,
              bool turns) const {
        load[i].force = select(touched, load[i].force + force, load[i].force);
        if (!turns) return;
        const auto [before, after] = around(rod, i);
        for (const int k : {before, after}) {
            const Vec3<P> more = load[k].couple + P(0.5) * (rod.slot[k].director * couple);
            load[k].couple = select(touched, more, load[k].couple);
        }
    }

private:
    /// At an end both are the one element there.
    static std::pair<int, int> around(const RodTile<W>& rod, int i) {
        return {i > 0 ? i - 1 : rod.group->closed() ? rod.n - 1 : 0, i < rod.n ? i : rod.n - 1};
    }
    static Behind element(const RodTile<W>& rod, int k) {
        const ElementConstants& c = rod.element[k];
        const Slot<W>& s = rod.slot[k];
        return {k, P(c.radius), transpose_times(s.director, s.spin)};
    }
    double largest_radius_ = 0;
};

/// Points of a body's surface.
template <int W> class SurfacePoints {
public:
    using P = Pack<W>;
    explicit SurfacePoints(const RodGroup& group) : body_(*group.body()) {
        for (const BodyShape::Point& p : body_.point) largest_radius_ = std::max(largest_radius_, p.radius);
    }
    double largest_radius() const { return largest_radius_; }
    int count(const RodTile<W>&) const { return static_cast<int>(body_.point.size()); }
    SKEIN_INLINE Vec3<P> position(const RodTile<W>& rod, int i) const {
        return rod.slot[0].position + transpose_times(rod.slot[0].director, place(i));
    }

    struct Behind {};
    void describe(const RodTile<W>& rod, int i, ContactState<P>& state, Behind&) const {
        const Slot<W>& s = rod.slot[0];
        state.radius_1 = P(body_.point[static_cast<std::size_t>(i)].radius);
        state.velocity_1 = s.velocity + transpose_times(s.director, cross(s.spin, place(i)));
        state.spin_1 = transpose_times(s.director, s.spin);
    }
    void push(const RodTile<W>& rod, SlotLoad<W>* load, int i, const Vec3<P>& force, const Vec3<P>& couple, Mask<W> touched,
              bool) const {
        const Quaternion<P>& q = rod.slot[0].director;
        load[0].force = select(touched, load[0].force + force, load[0].force);
        const Vec3<P> more = load[0].couple + (q * couple + cross(place(i), q * force));
        load[0].couple = select(touched, more, load[0].couple);
    }

private:
    SKEIN_INLINE Vec3<P> place(int i) const { return broadcast<W>(body_.point[static_cast<std::size_t>(i)].place); }
    const BodyShape& body_; ///< of the group
    double largest_radius_ = 0;
};

} // namespace skein
