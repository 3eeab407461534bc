// Rigid bodies, law "rigid": capsules, which are cylinders with half balls at both ends; a ball is one without length. A body is
// one element with two nodes, so that all that acts on rods acts on it.
//   x_c = (x_0 + x_1)/2,  V = (v_0 + v_1)/2
//   drift    x_c += h V;  the frame turns as a free circular top
//   kick     V <- a V + (h/m) b (f_0 + f_1),   w_i <- a_i w_i + (h/J_i) b_i (c + e3 x (l/2) Q (f_1 - f_0))_i
//   nodes    x = x_c -+ (l/2) d3,   v = V -+ (l/2) Q^T (w x e3):  written anew by both, so that they stay where the body has them
//   m = rho pi r^2 (l + 4 r/3)       J3 = m_c r^2/2 + 2 m_b r^2/5       J1 = J2 = m_c (l^2/12 + r^2/4) + m_b (2 r^2/5 + l^2/4 + 3 l
//   r/8)
// with the masses m_c = rho pi r^2 l of the cylinder and m_b = 4 rho pi r^3/3 of both half balls. a and b are those of
// rod/kick.hpp. Cost: 210 flop per body and step.
#pragma once

#include "rod/drift.hpp"
#include "rod/kick.hpp"

namespace skein {

/// Length of a ball over its radius: short enough for J1 = J3 to 2e-6, long enough for a direction.
inline constexpr double ball_length = 1e-6;

inline bool is_rigid(const RodGroup& group) { return group.law() == Law::rigid; }

/// Centre and its velocity.
template <int W> struct RigidCentre { Vec3<Pack<W>> position, velocity; };
template <int W> SKEIN_INLINE RigidCentre<W> rigid_centre(const Slot<W>* slot) {
    const Pack<W> half(0.5);
    return {half * (slot[0].position + slot[1].position), half * (slot[0].velocity + slot[1].velocity)};
}

namespace detail {

template <int W> SKEIN_INLINE void set_rigid_nodes(const RodTile<W>& rod, const RigidCentre<W>& centre) {
    Slot<W>&first = rod.slot[0], &last = rod.slot[1];
    const Pack<W> half_length(0.5 * rod.element[0].rest_length);
    const Vec3<Pack<W>>& w = first.spin;
    const Vec3<Pack<W>> arm = half_length * third_director(first.director);
    const Vec3<Pack<W>> turning = half_length * transpose_times(first.director, Vec3<Pack<W>>{w.y, -w.x, Pack<W>(0.0)});
    first.position = centre.position - arm;
    last.position = centre.position + arm;
    first.velocity = centre.velocity - turning;
    last.velocity = centre.velocity + turning;
}

} // namespace detail

template <int W> SKEIN_INLINE void rigid_drift(const RodTile<W>& rod, double length) {
    const Pack<W> h(length);
    RigidCentre<W> centre = rigid_centre(rod.slot);
    centre.position = fma(h, centre.velocity, centre.position);
    CircularTop::turn(rod.element[0], rod.slot[0].director, rod.slot[0].spin, h);
    detail::set_rigid_nodes(rod, centre);
}

template <int W> class RigidDriftPass final : public TilePass<W> {
public:
    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override { rigid_drift(rod, step.drift); }
};

/// In the place of the elastic pass: there is no load yet, and no stretch ever.
template <int W> class RigidRestPass final : public TilePass<W> {
public:
    void run(const RodTile<W>&, SlotLoad<W>* load, const Step&) const override { load[0] = load[1] = {{}, {}, Pack<W>(1.0)}; }
};

/// Rates of damping as constant ones: a body does not stretch.
inline DampingRates rigid_rates(DampingRates rates) {
    if (rates.follow_stretch()) rates.element[0] += rates.element_stretched[0];
    rates.element_stretched.clear();
    return rates;
}

template <int W> class RigidKickPass final : public TilePass<W> {
public:
    /// Of rigid_rates.
    explicit RigidKickPass(KicksOfGroup constants) : constants_(std::move(constants)) {}

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        using P = Pack<W>;
        const KickConstants& c = constants_[static_cast<std::size_t>(step.kick_length)];
        const KickConstants::Node& node = c.node[0];
        const KickConstants::Element& element = c.element[0];
        Slot<W>& s = rod.slot[0];
        RigidCentre<W> centre = rigid_centre(rod.slot);
        // A node has half the mass.
        centre.velocity = fma(P(0.5 * node.gain), load[0].force + load[1].force, P(node.decay) * centre.velocity);
        const Vec3<P> g = P(0.5 * rod.element[0].rest_length) * (s.director * (load[1].force - load[0].force));
        const Vec3<P> couple = load[0].couple + Vec3<P>{-g.y, g.x, P(0.0)};
        s.spin = {fma(P(element.gain.x), couple.x, P(element.decay.x) * s.spin.x),
                  fma(P(element.gain.y), couple.y, P(element.decay.y) * s.spin.y),
                  fma(P(element.gain.z), couple.z, P(element.decay.z) * s.spin.z)};
        detail::set_rigid_nodes(rod, centre);
    }

private:
    KicksOfGroup constants_;
};

} // namespace skein
