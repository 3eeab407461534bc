// Forces of a contact, for W pairs at once.                                                                theory.md
// (53)-(56)
//   n from 1 to 2 at distance d, overlap g = r1 + r2 - d, contact midway in it: arms a1 = (r1 - g/2) n, a2 = -(r2 -
//   g/2) n u = v1 + w1 x a1 - (v2 + w2 x a2),   u_n = u.n,   u_t = u - u_n n linear        N = max(0, k g + c u_n)
//   Hertz         N = max(0, sqrt(g) (k g + c u_n))
//   memory        k_t = kappa k (linear), kappa k sqrt(g) (Hertz);  x <- min(1, k_t before/k_t) x, in the tangent plane
//                 x turned about n by h (w1 + w2).n/2, then x <- x + h u_t,  T* = -k_t x - c_t u_t
//                 T = T* while |T*| <= mu_s N;  else T = mu_k N T*/|T*| and x = -T/k_t: a contact that slides has no
//                 dashpot
//   regularised   T = -mu_k N u_t/max(|u_t|, v_s), through a spring 1/k_h = h^2 sum(1/m) with the dashpot h k_h, of
//   which one step
//                 is solved:  y = x + 2 h u_t,  T = -mu_k N y/max(|y|, 2 h v_s + mu_k N/k_h),  x <- (x - T/k_h)/2
//   published     T = -(1 - f) mu_k N u_t/|u_t|,  f = 1 up to v_s, 0 from 1.5 v_s on, linear between
//   anisotropic   T = -N (mu u_a a + mu_side u_b b)/max(|u_t|, v_s),  a: the rod's axis in the plane, b = n x a, u_a
//   and u_b along
//                 them, mu = mu_k where u_a > 0, else that backward; through the same spring, each part of y by itself:
//                 z = y/(2 h max(|u_t|, v_s) + mu N/k_h),  T = -N mu z/max(|z|, 1)
//   on 1: force -N n + T, couple a1 x T;  on 2: force N n - T, couple -a2 x T
// A contact pushes, whatever its dashpot says. Where k_t rises with the overlap the pull of the spring stays and its
// length falls, so that no energy comes from nowhere; where k_t falls the length stays. Energy: springs store k g^2/2
// (Hertz 2 k g^2.5/5) and k_t x^2/2. Places and rates stand half a step apart, so over a step of rates u the mean of a
// force and of that a step before works, exactly. The viscous work is that of N and T beyond their springs; the
// friction work is the rest of what T takes: that of slip, and of springs that change otherwise than by motion. A
// contact in which several elements share, or several points of one, has a weight at each: its force and energy there,
// and its spring of friction, are that share of what is written above. Source: Cundall, Strack 1979 (Geotechnique 29,
// 47). Cost: 190 flop, of which six divisions and roots.
#pragma once

#include "contact/contact_law.hpp"

namespace skein {

template <class P> struct ContactState {
    Vec3<P> normal; ///< from 1 to 2
    P distance, radius_1, radius_2;
    Vec3<P> velocity_1, spin_1, velocity_2, spin_2; ///< of the axes beside the contact; lab
};

/// The spring of friction.
template <class P> struct FrictionSpring {
    Vec3<P> x;   ///< m
    P stiffness; ///< k_t with which it pulled, N/m

    SKEIN_INLINE P energy() const { return P(0.5) * stiffness * dot(x, x); } ///< J
};

/// Memory of a contact from one step to the next.
template <class P> struct ContactMemory {
    FrictionSpring<P> spring;
    Vec3<P> viscous_part; ///< of the force on 1, beyond both springs, N
    P weight;             ///< of the spring of friction

    SKEIN_INLINE P energy() const { return weight * spring.energy(); } ///< of that spring, J
};

template <int W> SKEIN_INLINE ContactMemory<double> lane(const ContactMemory<Pack<W>>& m, int i) {
    return {{lane(m.spring.x, i), m.spring.stiffness[i]}, lane(m.viscous_part, i), m.weight[i]};
}
template <int W> SKEIN_INLINE void set_lane(ContactMemory<Pack<W>>& m, int i, const ContactMemory<double>& one) {
    set_lane(m.spring.x, i, one.spring.x);
    m.spring.stiffness.set(i, one.spring.stiffness);
    set_lane(m.viscous_part, i, one.viscous_part);
    m.weight.set(i, one.weight);
}

/// Shares of a contact.
template <class P> struct ContactWeight {
    P normal = 1.0; ///< at this point
    P all = 1.0;    ///< of the contact with all its points, where it is this one that has friction
};

template <class P> struct ContactForce {
    Vec3<P> on_1;                  ///< N; on 2 the opposite
    Vec3<P> moment;                ///< n x T, N: the couple on i is arm_i times this
    P arm_1, arm_2;                ///< m
    P normal;                      ///< N
    P stiffness;                   ///< of the normal spring as it is, N/m
    P elastic_energy;              ///< J, now
    P friction_work, viscous_work; ///< J, in this step
};

/// How a rod lies on a wall whose friction depends on its direction.
template <class P> struct Lie {
    Vec3<P> axis;         ///< of the rod, lab
    P backward, sideways; ///< coefficients over that forward
};

struct ContactKinds {
    ContactNormal normal;
    ContactFriction friction;
};

/// A vector across the unit vector n, turned about it by an angle (Cayley's form, which keeps its length).
template <class P> SKEIN_INLINE Vec3<P> turned(const Vec3<P>& x, const Vec3<P>& n, P angle) {
    const P tangent = P(0.5) * angle, share = (tangent + tangent) / fma(tangent, tangent, P(1.0)); // of half the angle
    return x + share * (cross(n, x) - tangent * x);
}

/// Of the normal spring at an overlap, J; none where nothing touches.
template <class P> SKEIN_INLINE P normal_energy(ContactNormal normal, P stiffness, P overlap) {
    const P depth = max(overlap, P(0.0)), spring = stiffness * depth * depth;
    return normal == ContactNormal::hertz ? P(0.4) * (sqrt(depth) * spring) : P(0.5) * spring;
}

/// Direction of regularised friction times a number up to 1, against y; along with what friction has of it where it is
/// anisotropic. `length`: 2 h v_s of the law, m. `give`: mu_k N/k_h, m. A wall's contact, which alone is anisotropic,
/// has all of its weight.
template <class P>
SKEIN_INLINE Vec3<P> against_slip(const Vec3<P>& y, P weight, P length, P give, const Vec3<P>& n, const Lie<P>* lie) {
    const P one(1.0), tiny(1e-300);
    if (!lie) return (weight / max(max(weight * norm(y), fma(weight, length, give)), tiny)) * y;
    const Vec3<P> flat = lie->axis - dot(lie->axis, n) * n;
    const P along = dot(y, flat) / max(dot(flat, flat), tiny), forward = select(along > P(0.0), one, lie->backward);
    const P a = along / max(fma(give, forward, length), tiny), b = one / max(fma(give, lie->sideways, length), tiny);
    const Vec3<P> beside = b * (y - along * flat), z = fma(a, flat, beside);
    return (one / max(norm(z), one)) * fma(forward * a, flat, lie->sideways * beside);
}

/// `elsewhere`: normal force at the other points of this contact, which friction counts too. `memory`: as the contact
/// left it, 0 of a new one, but for the spring of another that it goes on from, with weight 0; then as it leaves it
/// now, 0 where nothing touches.
template <int W> SKEIN_INLINE ContactForce<Pack<W>>
contact_force(ContactKinds kinds, const ContactNumbers<Pack<W>>& law, const ContactState<Pack<W>>& in, double h,
              ContactMemory<Pack<W>>& memory, const ContactWeight<Pack<W>>& weight = {}, Pack<W> elsewhere = 0.0,
              const Lie<Pack<W>>* lie = nullptr) {
    using P = Pack<W>;
    const P zero(0.0), half(0.5), one(1.0), tiny(1e-150), step(h);
    const P overlap = in.radius_1 + in.radius_2 - in.distance, depth = max(overlap, zero);
    const auto touches = overlap > zero;
    const bool hertz = kinds.normal == ContactNormal::hertz;
    ContactForce<P> out;
    out.arm_1 = fnma(half, overlap, in.radius_1);
    out.arm_2 = fnma(half, overlap, in.radius_2);
    const Vec3<P>& n = in.normal;
    const Vec3<P> slip = in.velocity_1 - in.velocity_2 + cross(out.arm_1 * in.spin_1 + out.arm_2 * in.spin_2, n);
    const P approach = dot(slip, n);
    const Vec3<P> tangential = slip - approach * n;
    const P root = hertz ? sqrt(depth) : one, weighted = weight.normal * root,
            elastic = weighted * law.stiffness * depth;
    out.normal = select(touches, max(zero, fma(weighted * law.damping, approach, elastic)), zero);
    out.stiffness = select(touches, hertz ? P(1.5) * root * law.stiffness : law.stiffness, zero);
    out.elastic_energy = P(hertz ? 0.4 : 0.5) * elastic * depth;
    const Vec3<P> none{zero, zero, zero}, half_way = (half * step) * tangential;
    const P viscous_normal = select(touches, out.normal - elastic, zero), normal_before = -dot(memory.viscous_part, n);
    out.viscous_work = half * step * approach * (normal_before + viscous_normal);
    out.friction_work = zero;
    const P pressed = out.normal + elsewhere;

    ContactMemory<P> now{{none, zero}, none, zero};
    Vec3<P> friction = none;
    if (kinds.friction == ContactFriction::memory) {
        const P stiffness = law.tangential_stiffness * root;
        const Vec3<P> kept =
            hertz ? min(one, memory.spring.stiffness / max(stiffness, tiny)) * memory.spring.x : memory.spring.x;
        const Vec3<P> in_plane =
            fma(step, tangential, turned(kept - dot(kept, n) * n, n, half * step * dot(in.spin_1 + in.spin_2, n)));
        const P spring = weight.all * stiffness, dashpot = weight.all * law.tangential_damping;
        const Vec3<P> trial = -(spring * in_plane) - dashpot * tangential;
        const P squared = dot(trial, trial), limit = law.static_friction * pressed;
        const auto sticks = squared <= limit * limit;
        Vec3<P> after = in_plane, viscous_part = -(dashpot * tangential);
        friction = trial;
        if (any(!sticks)) {
            const P inverse = one / (max(sqrt(squared), tiny) * max(spring, tiny));
            const Vec3<P> slides = (law.kinetic_friction * pressed * inverse) * trial; // over k_t
            friction = select(sticks, trial, spring * slides);
            after = select(sticks, in_plane, -slides);
            viscous_part = select(sticks, viscous_part, none);
        }
        friction = select(touches, friction, none);
        now = {{select(touches, after, none), select(touches, stiffness, zero)},
               select(touches, viscous_part, none),
               select(touches, weight.all, zero)};
        const P viscous_work = -dot(memory.viscous_part + now.viscous_part, half_way), energy = now.energy();
        const Vec3<P> before = memory.viscous_part - (memory.weight * memory.spring.stiffness) * memory.spring.x;
        out.friction_work = memory.energy() - energy - viscous_work - dot(before + friction, half_way);
        out.viscous_work += viscous_work;
        out.elastic_energy += energy;
    } else if (has_spring(kinds.friction)) {
        const Vec3<P>& kept = memory.spring.x;
        const Vec3<P> x = turned(kept - dot(kept, n) * n, n, half * step * dot(in.spin_1 + in.spin_2, n)),
                      y = fma(law.twice_step, tangential, x);
        const P most = law.kinetic_friction * pressed, give = most * law.compliance,
                speed = lie ? max(norm(tangential), law.slip_speed) : law.slip_speed;
        const Vec3<P> against = against_slip(y, weight.all, law.twice_step * speed, give, n, lie);
        const P stiffness = select(law.compliance > zero, one / max(law.compliance, tiny), zero);
        const Vec3<P> after = half * fma(give / max(weight.all, tiny), against, x);
        friction = select(touches, -(most * against), none);
        now = {{select(touches, after, none), select(touches, stiffness, zero)},
               select(touches, fma(weight.all * stiffness, after, friction), none),
               select(touches, weight.all, zero)};
        const P energy = now.energy();
        const Vec3<P> before = memory.viscous_part - (memory.weight * memory.spring.stiffness) * memory.spring.x;
        out.friction_work = memory.energy() - energy - dot(before + friction, half_way);
        out.elastic_energy += energy;
    } else if (kinds.friction == ContactFriction::published) {
        const P speed = norm(tangential), rise = (speed - law.slip_speed) / max(half * law.slip_speed, tiny),
                share = law.kinetic_friction * pressed / max(speed, tiny) * min(max(rise, zero), one);
        friction = -(share * tangential);
        now.viscous_part = friction;
        out.friction_work = -dot(memory.viscous_part + friction, half_way);
    }
    now.viscous_part = now.viscous_part - viscous_normal * n;
    out.viscous_work = select(touches, out.viscous_work, zero);
    out.friction_work =
        select(touches, out.friction_work, memory.energy()); // a contact that ends loses the energy of its spring
    memory = now;
    out.moment = cross(n, friction);
    out.on_1 = friction - out.normal * n;
    return out;
}

} // namespace skein
