// Forces of a contact, for W pairs at once.                                                    theory.md (53)-(56)
//   n from 1 to 2 at distance d, overlap g = r1 + r2 - d, contact midway in it
//   arms          a1 = (r1 - g/2) n, a2 = -(r2 - g/2) n
//   slip          u = v1 + w1 x a1 - (v2 + w2 x a2),  u_n = u.n,  u_t = u - u_n n
//   linear        N = max(0, k g + c u_n)
//   Hertz         N = max(0, sqrt(g) (k g + c u_n))
//   memory        k_t = kappa k (linear), kappa k sqrt(g) (Hertz);  x <- min(1, k_t before/k_t) x, in the tangent plane
//                 x turned about n by h (w1 + w2).n/2, then x <- x + h u_t,  T* = -k_t x - c_t u_t
//                 T = T* while |T*| <= mu_s N;  else T = mu_k N T*/|T*| and x = -T/k_t, without a dashpot
//   regularised   T = -mu_k N u_t/max(|u_t|, v_s), through a spring 1/k_h = h^2 sum(1/m) with the dashpot h k_h:
//                 one step: y = x + 2 h u_t,  T = -mu_k N y/max(|y|, 2 h v_s + mu_k N/k_h),  x <- (x - T/k_h)/2
//   published     T = -(1 - f) mu_k N u_t/|u_t|,  f = 1 up to v_s, 0 from 1.5 v_s on, linear between
//   anisotropic   T = -N (mu u_a a + mu_side u_b b)/max(|u_t|, v_s),  a the rod's axis in the plane, b = n x a,
//                 u_a and u_b along them, mu = mu_k where u_a > 0, else that backward; each part of y by itself in the
//                 spring: z = y/(2 h max(|u_t|, v_s) + mu N/k_h),  T = -N mu z/max(|z|, 1)
//   on 1          force -N n + T, couple a1 x T;  on 2 force N n - T, couple -a2 x T
// A contact pushes, whatever its dashpot says. Where k_t rises with the overlap the pull of the spring stays and its
// length falls, so that no energy comes from nowhere; where k_t falls the length stays. Springs store k g^2/2
// (Hertz 2 k g^2.5/5) and k_t x^2/2. Places and rates stand half a step apart. Over a step of rates u the mean of a
// force now and a step before works, exactly. The viscous work is that of N and T beyond their springs. The friction
// work is the rest of what T takes: slip, and springs that change otherwise than by motion. Elements or points that
// share a contact have a weight each: force, energy and the spring of friction are that share of the above. Source:
// Cundall, Strack 1979 (Geotechnique 29, 47). Cost: 190 flop, of which six divisions and roots.
#pragma once

#include "contact/contact_law.hpp"

namespace skein {

template <class P> struct ContactState {
    Vec3<P> normal; ///< from 1 to 2
    P distance, radius_1, radius_2;
    Vec3<P> velocity_1, spin_1, velocity_2, spin_2; ///< rates of the axes at the contact; lab
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
    Vec3<P> viscous_part; ///< force on 1 beyond both springs, N
    P weight;             ///< weight of the spring of friction

    SKEIN_INLINE P energy() const { return weight * spring.energy(); } ///< energy of that spring, J
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
    P all = 1.0;    ///< share of the contact with all its points, where this point has the friction
};

template <class P> struct ContactForce {
    Vec3<P> on_1;                  ///< N; on 2 the opposite
    Vec3<P> moment;                ///< n x T, N: the couple on i is arm_i times this
    P arm_1, arm_2;                ///< m
    P normal;                      ///< N
    P stiffness;                   ///< slope of the normal force over the overlap, N/m
    P elastic_energy;              ///< J, now
    P friction_work, viscous_work; ///< J, in this step
};

/// Direction of a rod on a wall with anisotropic friction.
template <class P> struct Lie {
    Vec3<P> axis;         ///< axis of the rod, lab
    P backward, sideways; ///< coefficients over that forward
};

struct ContactKinds {
    ContactNormal normal;
    ContactFriction friction;
};

/// A vector across the unit vector n, turned about it by an angle (Cayley's form, which keeps its length).
template <class P> SKEIN_INLINE Vec3<P> turned(const Vec3<P>& x, const Vec3<P>& n, P angle) {
    const P tangent = P(0.5) * angle,
            share =
                (tangent + tangent) / fma(tangent, tangent, P(1.0)); // tangent of half the angle, and sine of the angle
    return x + share * (cross(n, x) - tangent * x);
}

/// Energy of the normal spring at an overlap, J; 0 where nothing touches.
template <class P> SKEIN_INLINE P normal_energy(ContactNormal normal, P stiffness, P overlap) {
    const P depth = max(overlap, P(0.0)), spring = stiffness * depth * depth;
    return normal == ContactNormal::hertz ? P(0.4) * (sqrt(depth) * spring) : P(0.5) * spring;
}

/// Direction of regularised friction times a number up to 1, along y. `length`: 2 h v_s of the law, m. `give`: mu_k
/// N/k_h, m. Anisotropic friction is that of walls, whose contacts have all of their weight.
template <class P>
SKEIN_INLINE Vec3<P> against_slip(const Vec3<P>& y, P weight, P length, P give, const Vec3<P>& n, const Lie<P>* lie) {
    const P one(1.0), tiny(1e-300);
    if (!lie) return (weight / max(max(weight * norm(y), fma(weight, length, give)), tiny)) * y;
    const Vec3<P> flat = lie->axis - dot(lie->axis, n) * n;
    const P along = dot(y, flat) / max(dot(flat, flat), tiny), forward = select(along > P(0.0), one, lie->backward);
    const P a = along / max(fma(give, forward, length), tiny), b = one / max(fma(give, lie->sideways, length), tiny);
    const Vec3<P> transverse = b * (y - along * flat), z = fma(a, flat, transverse);
    return (one / max(norm(z), one)) * fma(forward * a, flat, lie->sideways * transverse);
}

namespace detail {

/// The numbers of a step that friction depends on.
template <int W> struct Sliding {
    using P = Pack<W>;
    Vec3<P> normal, tangential; ///< unit vector; velocity of slip, m/s
    Vec3<P> half_way;           ///< half of the slip in the step, m
    P step, turn;               ///< s; angle by which the tangent plane turns about the normal, rad
    P pressed, root, weight;    ///< normal force with all points, N; sqrt(g) of Hertz, else 1; share with all points
    Mask<W> touches;

    /// A spring of the step before, in the tangent plane of this one.
    SKEIN_INLINE Vec3<P> in_plane(const Vec3<P>& x) const { return turned(x - dot(x, normal) * normal, normal, turn); }
    SKEIN_INLINE P if_touching(const P& x) const { return select(touches, x, P(0.0)); }
    SKEIN_INLINE Vec3<P> if_touching(const Vec3<P>& x) const {
        return select(touches, x, Vec3<P>{P(0.0), P(0.0), P(0.0)});
    }
};

/// The same of several points that may twist about their mean normal. The normal part of slip, spring and force is the
/// turn times the radius of the points, and the couple over it.
template <int W> struct SlidingPatch : Sliding<W> {
    using P = Pack<W>;
    Vec3<P> turning; ///< by which the spring goes round with both bodies, rad
    P twisted;       ///< share of its normal part that it keeps

    SKEIN_INLINE Vec3<P> in_plane(const Vec3<P>& x) const {
        const Vec3<P> tangent = P(0.5) * turning, across = cross(tangent, x);
        const P share = P(2.0) / (P(1.0) + dot(tangent, tangent));
        const Vec3<P> after = x + share * (across + cross(tangent, across));
        return after - ((P(1.0) - twisted) * dot(after, this->normal)) * this->normal;
    }
};

template <int W> struct Friction {
    Vec3<Pack<W>> force; ///< on 1, N
    ContactMemory<Pack<W>> memory;
};

/// Adds the normal force, and the stiffness, energy and half of the viscous work of its spring and dashpot.
template <class P> SKEIN_INLINE void add_normal_force(const ContactNumbers<P>& law, bool hertz, P overlap, P root,
                                                      P weight, P approach, ContactForce<P>& out, P& elastic) {
    const P zero(0.0), depth = max(overlap, zero), weighted = weight * root;
    const auto touches = overlap > zero;
    elastic = weighted * law.stiffness * depth;
    out.normal = select(touches, max(zero, fma(weighted * law.damping, approach, elastic)), zero);
    out.stiffness = select(touches, hertz ? P(1.5) * root * law.stiffness : law.stiffness, zero);
    out.elastic_energy = P(hertz ? 0.4 : 0.5) * elastic * depth;
}

/// Spring and dashpot of `memory`: they stick, or slide at mu_k N without a dashpot.
template <int W, class S> SKEIN_INLINE void friction_of_memory(Friction<W>& out, bool hertz,
                                                               const ContactNumbers<Pack<W>>& law, const S& in,
                                                               const FrictionSpring<Pack<W>>& last) {
    using P = Pack<W>;
    const P zero(0.0), one(1.0), tiny(1e-150),
        stiffness = min(law.tangential_stiffness * in.root, law.stiffest_tangential);
    const Vec3<P> none{zero, zero, zero},
        kept = hertz ? min(one, last.stiffness / max(stiffness, tiny)) * last.x : last.x,
        x = fma(in.step, in.tangential, in.in_plane(kept));
    const P spring = in.weight * stiffness, dashpot = in.weight * law.tangential_damping;
    const Vec3<P> trial = -(spring * x) - dashpot * in.tangential;
    const P squared = dot(trial, trial), limit = law.static_friction * in.pressed;
    const auto sticks = squared <= limit * limit;
    Vec3<P> force = trial, after = x, viscous_part = -(dashpot * in.tangential);
    if (any(!sticks)) {
        const P inverse = one / (max(sqrt(squared), tiny) * max(spring, tiny));
        const Vec3<P> slides = (law.kinetic_friction * in.pressed * inverse) * trial; // over k_t
        force = select(sticks, trial, spring * slides);
        after = select(sticks, x, -slides);
        viscous_part = select(sticks, viscous_part, none);
    }
    out.force = in.if_touching(force);
    out.memory.spring = {in.if_touching(after), in.if_touching(stiffness)};
    out.memory.viscous_part = in.if_touching(viscous_part);
    out.memory.weight = in.if_touching(in.weight);
}

/// One step of regularised or anisotropic friction through its spring.
template <int W, class S> SKEIN_INLINE void regularised_friction(Friction<W>& out, const ContactNumbers<Pack<W>>& law,
                                                                 const S& in, const FrictionSpring<Pack<W>>& last,
                                                                 const Lie<Pack<W>>* lie) {
    using P = Pack<W>;
    const P zero(0.0), half(0.5), one(1.0), tiny(1e-150);
    const Vec3<P> x = in.in_plane(last.x), y = fma(law.twice_step, in.tangential, x);
    const P most = law.kinetic_friction * in.pressed, give = most * law.compliance,
            speed = lie ? max(norm(in.tangential), law.slip_speed) : law.slip_speed;
    const Vec3<P> against = against_slip(y, in.weight, law.twice_step * speed, give, in.normal, lie);
    const P stiffness = select(law.compliance > zero, one / max(law.compliance, tiny), zero);
    const Vec3<P> after = half * fma(give / max(in.weight, tiny), against, x),
                  force = in.if_touching(-(most * against));
    out.force = force;
    out.memory.spring = {in.if_touching(after), in.if_touching(stiffness)};
    out.memory.viscous_part = in.if_touching(fma(in.weight * stiffness, after, force));
    out.memory.weight = in.if_touching(in.weight);
}

/// Friction that rises from the slip speed to 1.5 times that, as published.
template <int W>
SKEIN_INLINE void published_friction(Friction<W>& out, const ContactNumbers<Pack<W>>& law, const Sliding<W>& in) {
    using P = Pack<W>;
    const P zero(0.0), half(0.5), one(1.0), tiny(1e-150),
        speed = norm(in.tangential), rise = (speed - law.slip_speed) / max(half * law.slip_speed, tiny),
        share = law.kinetic_friction * in.pressed / max(speed, tiny) * min(max(rise, zero), one);
    const Vec3<P> force = -(share * in.tangential);
    out.force = out.memory.viscous_part = force;
}

/// Energy that friction dissipates in a step: the work of its force, less what springs store and `dashpot` takes.
template <class P> SKEIN_INLINE P work_of_friction(const ContactMemory<P>& last, const ContactMemory<P>& now,
                                                   const Vec3<P>& force, const Vec3<P>& half_way, P dashpot) {
    const Vec3<P> before = last.viscous_part - (last.weight * last.spring.stiffness) * last.spring.x;
    return last.energy() - now.energy() - dashpot - dot(before + force, half_way);
}

/// Adds the works of friction and the energy of its spring. `last`: memory of the step before.
template <int W, class S> SKEIN_INLINE Friction<W> add_friction(ContactKinds kinds, const ContactNumbers<Pack<W>>& law,
                                                                const S& in, const ContactMemory<Pack<W>>& last,
                                                                const Lie<Pack<W>>* lie, ContactForce<Pack<W>>& out) {
    using P = Pack<W>;
    const P zero(0.0);
    Friction<W> friction{{zero, zero, zero}, {{{zero, zero, zero}, zero}, {zero, zero, zero}, zero}};
    const ContactMemory<P>& now = friction.memory;
    if (kinds.friction == ContactFriction::memory) {
        friction_of_memory<W>(friction, kinds.normal == ContactNormal::hertz, law, in, last.spring);
        const P dashpot = -dot(last.viscous_part + now.viscous_part, in.half_way);
        out.friction_work = work_of_friction(last, now, friction.force, in.half_way, dashpot);
        out.viscous_work += dashpot;
        out.elastic_energy += now.energy();
    } else if (has_spring(kinds.friction)) {
        regularised_friction<W>(friction, law, in, last.spring, lie);
        out.friction_work = work_of_friction(last, now, friction.force, in.half_way, zero);
        out.elastic_energy += now.energy();
    } else if (kinds.friction == ContactFriction::published) {
        published_friction<W>(friction, law, in);
        out.friction_work = -dot(last.viscous_part + friction.force, in.half_way);
    }
    return friction;
}

} // namespace detail

/// `elsewhere`: normal force at the other points of the contact, N. `memory` is that of the step before, or an
/// inherited spring with weight 0 of a new contact. It becomes that of this step, 0 where nothing touches.
template <int W> SKEIN_INLINE ContactForce<Pack<W>>
contact_force(ContactKinds kinds, const ContactNumbers<Pack<W>>& law, const ContactState<Pack<W>>& in, double h,
              ContactMemory<Pack<W>>& memory, const ContactWeight<Pack<W>>& weight = {}, Pack<W> elsewhere = 0.0,
              const Lie<Pack<W>>* lie = nullptr) {
    using P = Pack<W>;
    const P zero(0.0), half(0.5), step(h), overlap = in.radius_1 + in.radius_2 - in.distance;
    const bool hertz = kinds.normal == ContactNormal::hertz;
    const Vec3<P>& n = in.normal;
    ContactForce<P> out;
    // Velocity of slip.
    out.arm_1 = fnma(half, overlap, in.radius_1);
    out.arm_2 = fnma(half, overlap, in.radius_2);
    const Vec3<P> slip = in.velocity_1 - in.velocity_2 + cross(out.arm_1 * in.spin_1 + out.arm_2 * in.spin_2, n);
    const P approach = dot(slip, n);
    const Vec3<P> tangential = slip - approach * n;
    // Normal force.
    const P root = hertz ? sqrt(max(overlap, zero)) : P(1.0);
    P elastic;
    detail::add_normal_force(law, hertz, overlap, root, weight.normal, approach, out, elastic);
    const auto touches = overlap > zero;
    const P viscous_normal = select(touches, out.normal - elastic, zero), normal_before = -dot(memory.viscous_part, n);
    out.viscous_work = half * step * approach * (normal_before + viscous_normal);
    out.friction_work = zero;
    // Friction and its work.
    const detail::Sliding<W> sliding{n,
                                     tangential,
                                     (half * step) * tangential,
                                     step,
                                     half * step * dot(in.spin_1 + in.spin_2, n),
                                     out.normal + elsewhere,
                                     root,
                                     weight.all,
                                     touches};
    detail::Friction<W> friction = detail::add_friction<W>(kinds, law, sliding, memory, lie, out);
    ContactMemory<P>& now = friction.memory;
    now.viscous_part = now.viscous_part - viscous_normal * n;
    out.viscous_work = select(touches, out.viscous_work, zero);
    // A contact that ends loses the energy of its spring.
    out.friction_work = select(touches, out.friction_work, memory.energy());
    memory = now;
    // Loads on both bodies.
    out.moment = cross(n, friction.force);
    out.on_1 = friction.force - out.normal * n;
    return out;
}

} // namespace skein
