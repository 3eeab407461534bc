// Points of a group's rods that touch walls, as balls, and what a force and a couple there do to the rod.
#pragma once

#include "contact/response.hpp"
#include "rod/body_shape.hpp"
#include "skein/rod/tile.hpp"

#include <algorithm>
#include <cstring>

namespace skein {

/// Of one rod: its nodes, or the points of a body's surface.
inline std::size_t wall_points(const RodGroup& group) {
    return group.strained() ? static_cast<std::size_t>(group.slots()) : group.body()->point.size();
}

/// Numbers of N points one by one, to be read as packs; the other way round likewise.
template <int N> struct alignas(64) NumberLanes {
    double at[N];

    Pack<N> pack() const {
        Pack<N> p;
        std::memcpy(&p, at, sizeof p);
        return p;
    }
    void take(const Pack<N>& p) { std::memcpy(at, &p, sizeof p); }
};
template <int N> struct VectorLanes {
    NumberLanes<N> x, y, z;

    SKEIN_INLINE void put(int n, const Vec3d& v) { x.at[n] = v.x, y.at[n] = v.y, z.at[n] = v.z; }
    SKEIN_INLINE Vec3d operator[](int n) const { return {x.at[n], y.at[n], z.at[n]}; }
    Vec3<Pack<N>> pack() const { return {x.pack(), y.pack(), z.pack()}; }
    void take(const Vec3<Pack<N>>& v) { x.take(v.x), y.take(v.y), z.take(v.z); }
};
template <int N> struct QuaternionLanes {
    NumberLanes<N> w;
    VectorLanes<N> v;

    SKEIN_INLINE void put(int n, const Quaterniond& q) { w.at[n] = q.w, v.put(n, q.v); }
    Quaternion<Pack<N>> pack() const { return {w.pack(), v.pack()}; }
};

template <int W> SKEIN_INLINE void add_to_lane(Vec3<Pack<W>>& to, int l, const Vec3d& more) {
    to.x.set(l, to.x[l] + more.x), to.y.set(l, to.y[l] + more.y), to.z.set(l, to.z[l] + more.z);
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

    double radius(const RodTile<W>& rod, int i) const {
        const auto [before, after] = around(rod, i);
        return 0.5 * (rod.element[before].radius + rod.element[after].radius);
    }

    /// What is needed of points that touch, each of a lane of its own: N of them, from first to last.
    template <int N> struct Touching {
        NumberLanes<N> radius;
        VectorLanes<N> velocity, spin[2];
        QuaternionLanes<N> director[2]; ///< of the elements before and after

        void put(int n, const RodNodes& nodes, const RodTile<W>& rod, int i, int l) {
            radius.at[n] = nodes.radius(rod, i);
            velocity.put(n, lane(rod.slot[i].velocity, l));
            const auto [before, after] = around(rod, i);
            const Slot<W>* const slot[2] = {&rod.slot[before], &rod.slot[after]};
            for (const int k : {0, 1}) {
                spin[k].put(n, lane(slot[k]->spin, l));
                director[k].put(n, lane(slot[k]->director, l));
            }
        }
        void describe(ContactState<Pack<N>>& state) const {
            state.radius_1 = radius.pack();
            state.velocity_1 = velocity.pack();
            state.spin_1 = Pack<N>(0.5) * (transpose_times(director[0].pack(), spin[0].pack()) +
                                           transpose_times(director[1].pack(), spin[1].pack()));
        }
        /// Of the rod there: the sum of its elements' tangents.
        Vec3<Pack<N>> axis() const { return third_director(director[0].pack()) + third_director(director[1].pack()); }
        /// A force and a couple in the lab, which add() gives to the rod of each.
        void push(const Vec3<Pack<N>>& force, const Vec3<Pack<N>>& couple) {
            force_.take(force);
            for (const int k : {0, 1}) couple_[k].take(Pack<N>(0.5) * (director[k].pack() * couple));
        }
        void add(int n, const RodTile<W>& rod, SlotLoad<W>* load, int i, int l) const {
            add_to_lane(load[i].force, l, force_[n]);
            const auto [before, after] = around(rod, i);
            add_to_lane(load[before].couple, l, couple_[0][n]);
            add_to_lane(load[after].couple, l, couple_[1][n]);
        }

    private:
        VectorLanes<N> force_, couple_[2];
    };

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
    explicit SurfacePoints(const RodGroup& group) : body_(*group.body()) {
        for (const BodyShape::Point& p : body_.point) largest_radius_ = std::max(largest_radius_, p.radius);
    }
    double largest_radius() const { return largest_radius_; }
    int count(const RodTile<W>&) const { return static_cast<int>(body_.point.size()); }
    SKEIN_INLINE Vec3<P> position(const RodTile<W>& rod, int i) const {
        return rod.slot[0].position + transpose_times(rod.slot[0].director, place(i));
    }

    double radius(const RodTile<W>&, int i) const { return body_.point[static_cast<std::size_t>(i)].radius; }

    template <int N> struct Touching {
        NumberLanes<N> radius;
        VectorLanes<N> place, velocity, spin;
        QuaternionLanes<N> director;

        void put(int n, const SurfacePoints& points, const RodTile<W>& rod, int i, int l) {
            const BodyShape::Point& point = points.body_.point[static_cast<std::size_t>(i)];
            const Slot<W>& s = rod.slot[0];
            radius.at[n] = point.radius;
            place.put(n, point.place), velocity.put(n, lane(s.velocity, l)), spin.put(n, lane(s.spin, l));
            director.put(n, lane(s.director, l));
        }
        void describe(ContactState<Pack<N>>& state) const {
            const Quaternion<Pack<N>> q = director.pack();
            state.radius_1 = radius.pack();
            state.velocity_1 = velocity.pack() + transpose_times(q, cross(spin.pack(), place.pack()));
            state.spin_1 = transpose_times(q, spin.pack());
        }
        Vec3<Pack<N>> axis() const { return third_director(director.pack()); }
        void push(const Vec3<Pack<N>>& force, const Vec3<Pack<N>>& couple) {
            const Quaternion<Pack<N>> q = director.pack();
            force_.take(force);
            couple_.take(q * couple + cross(place.pack(), q * force));
        }
        void add(int n, const RodTile<W>&, SlotLoad<W>* load, int, int l) const {
            add_to_lane(load[0].force, l, force_[n]);
            add_to_lane(load[0].couple, l, couple_[n]);
        }

    private:
        VectorLanes<N> force_, couple_;
    };

private:
    SKEIN_INLINE Vec3<P> place(int i) const { return broadcast<W>(body_.point[static_cast<std::size_t>(i)].place); }
    const BodyShape& body_; ///< of the group
    double largest_radius_ = 0;
};

} // namespace skein
