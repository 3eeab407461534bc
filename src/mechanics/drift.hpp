// Exact drift: positions at constant velocity, frames as free tops. theory.md (16)-(19)
//   x += h v
//   circular (J1 = J2):  u = h (w1, w2, J3/J1 w3);  Q <- R(u) Q;  then Q and w turn about d3 by (1 - J3/J1) h w3
//   elliptic:            half a turn about the axis r of the smaller of J1, J2 by (h/2) p_r (1/J_r - 1/J_b);
//                        the top about d3 with transverse inertia J_b; the other half. p = J w, b the third axis.
//                        (The wrong choice of r fails.)
// Both conserve the lab angular momentum to round-off. Half drifts between two kicks merge into one (exactly for
// circles). Cost: 112 flop per element (circular), 189 (elliptic).
#pragma once

#include "core/rotation.hpp"
#include "skein/tiles/mapping.hpp"
#include "time/every.hpp"

namespace skein {

namespace detail {

/// Turns a pair of components by an angle with this sine and cosine.
template <class P> SKEIN_INLINE void turn(P& j, P& k, P sine, P cosine) {
    const P turned = fma(cosine, j, sine * k);
    k = fma(cosine, k, -(sine * j));
    j = turned;
}

/// Rotates a frame and a body vector about body axis 0, 1 or 2 by twice the angle `half`.
template <int Axis, int W> SKEIN_INLINE void turn_about(Quaternion<Pack<W>>& q, Vec3<Pack<W>>& p, Pack<W> half) {
    const HalfAngle<Pack<W>> f = half_angle(half * half);
    const Pack<W> s = f.sine_over * half, c = f.cosine;
    const Pack<W> sine = (s + s) * c, cosine = fnma(s + s, s, Pack<W>(1.0));
    if constexpr (Axis == 0) {
        turn(q.v.x, q.w, s, c);
        turn(q.v.y, q.v.z, s, c);
        turn(p.y, p.z, sine, cosine);
    }
    if constexpr (Axis == 1) {
        turn(q.v.y, q.w, s, c);
        turn(q.v.z, q.v.x, s, c);
        turn(p.z, p.x, sine, cosine);
    }
    if constexpr (Axis == 2) {
        turn(q.v.z, q.w, s, c);
        turn(q.v.x, q.v.y, s, c);
        turn(p.x, p.y, sine, cosine);
    }
}

} // namespace detail

/// Top with J1 = J2. J3/J1 is 2 for the inertia of the section itself, less where the rotary inertia is scaled.
struct CircularGyration {
    template <class C, int W>
    SKEIN_INLINE static void turn(const C& c, Quaternion<Pack<W>>& q, Vec3<Pack<W>>& w, Pack<W> h) {
        const Pack<W> ratio(c.inertia_ratio);
        const Vec3<Pack<W>> half = (Pack<W>(0.5) * h) * w;
        Quaternion<Pack<W>> turned = rotation_by_twice<W>({half.x, half.y, ratio * half.z});
        detail::turn_about<2>(turned, w, fnma(ratio, half.z, half.z));
        q = turned * q;
    }
};

/// Top with J1 != J2; SmallAxis is the axis of the smaller one, 0 or 1. J3 = J1 + J2 is the largest unless the others
/// are scaled.
template <int SmallAxis> struct EllipticGyration {
    template <class C, int W>
    SKEIN_INLINE static void turn(const C& c, Quaternion<Pack<W>>& q, Vec3<Pack<W>>& w, Pack<W> h) {
        using P = Pack<W>;
        const auto small = SmallAxis == 0 ? c.inv_inertia.x : c.inv_inertia.y,
                   other = SmallAxis == 0 ? c.inv_inertia.y : c.inv_inertia.x;
        const P half_rest_rate(0.25 * (small - other)), top(other), half_axial(0.5 * (c.inv_inertia.z - other));
        Vec3<P> p = scale(broadcast<W>(c.inertia), w);
        const auto half_rest = [&] {
            detail::turn_about<SmallAxis>(q, p, h * (half_rest_rate * (SmallAxis == 0 ? p.x : p.y)));
        };
        half_rest();
        q = rotation((h * top) * p) * q;
        detail::turn_about<2>(q, p, h * (half_axial * p.z));
        half_rest();
        w = scale(broadcast<W>(c.inv_inertia), p);
    }
};

/// Elliptic top whose smaller axis is chosen element by element, for lanes with the same constants.
struct EllipticGyrationOfEach {
    template <int W>
    SKEIN_INLINE static void turn(const ElementConstants& c, Quaternion<Pack<W>>& q, Vec3<Pack<W>>& w, Pack<W> h) {
        if (c.inertia.x < c.inertia.y) EllipticGyration<0>::turn(c, q, w, h);
        else EllipticGyration<1>::turn(c, q, w, h);
    }
};

template <class Top, int W, class Map = Across<W>> SKEIN_INLINE void drift(const RodTile<W>& rod, double length) {
    const Pack<W> h(length);
    for (int k = 0; k < rod.n; ++k) {
        Slot<W>& s = rod.slot[k];
        s.position = fma(h, s.velocity, s.position);
        Top::turn(Map::element(rod, k), s.director, s.spin, h);
    }
    if (rod.last < rod.n) return; // a body
    Slot<W>& last = rod.slot[rod.last];
    last.position = fma(h, last.velocity, last.position);
}

template <class Top, int W, class Map = Across<W>> class DriftPass final : public TilePass<W> {
public:
    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        drift<Top, W, Map>(rod, step.drift);
    }
};

/// q <- q (3 - |q|^2)/2 removes round-off from the frames at an interval of steps. theory.md (25)
template <int W, class Map = Across<W>> class OrthonormalisePass final : public TilePass<W> {
public:
    static constexpr std::int64_t interval = 512; ///< steps; a steady top gains up to 1e-16 in each
    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        if (!Every{interval}.due(step.index) || !step.completes) return;
        using P = Pack<W>;
        for (int k = 0; k < rod.n; ++k) {
            Quaternion<P>& q = rod.slot[k].director;
            P scale = fnma(P(0.5), dot(q, q), P(1.5));
            if constexpr (Map::along)
                scale = select(Map::element(rod, k).absent > P(0.0), P(1.0), scale); // a wall's frame stays
            q = {scale * q.w, scale * q.v};
        }
    }
};

/// Node n of a ring is node 0: its slot takes that node's place after the drift, and hands over its load before the
/// kick.
template <int W> void close_ring(const RodTile<W>& rod) {
    if (!rod.group->closed()) return;
    rod.slot[rod.n].position = rod.slot[0].position;
    rod.slot[rod.n].velocity = rod.slot[0].velocity;
}
template <int W> class CloseRingPass final : public TilePass<W> {
public:
    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step&) const override { close_ring(rod); }
};
template <int W> class FoldRingPass final : public TilePass<W> {
public:
    bool adds_loads() const override { return false; }
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        load[0].force += load[rod.n].force;
    }
};

} // namespace skein
