// Laws of joints with a free axis, W at a time: the angle of a hinge, the way of a slider, the length of a distance.
//                                                                                        theory.md (73f)-(73h)
//   hinge      angle q = 2 atan2(v.n, w),  (w, v) = Q2 (C Q1)^T;  couple Q G on 2, -Q G on 1,  G = dq/d(turn of 2)
//   slider     way q = n2.d;  force Q n2 on 2 and -Q n2 on 1, both at the point of 1; across it the point spring acts
//   distance   q = |d| - L;  force Q d/|d| on 2, and the opposite on 1
//   bushing    d and phi in the frame of 1:  F = K d + N u on 1 at the point of 2,  u of 2's point against 1;
//              couples of K_t phi as of a cell (15), and N_t (w2 - w1);  K, N, K_t, N_t diagonal
//   universal  two axes stay at right angles: U = k_t (n1.m2)^2/2; no free axis of its own
//   Q          spring, dashpot, stops, dry friction with memory, motor
#pragma once

#include "joints/axis_spec.hpp"
#include "joints/joint_law.hpp"

namespace skein {

/// Memory of a joint's axis from step to step.
template <class P> struct AxisMemory {
    P anchor;                ///< where the spring of friction has no force
    P position;              ///< of the last step
    P rate;                  ///< half a step before the last position
    P steps;                 ///< made so far, up to 2
    P interval;              ///< length of the last step, s
    P motor, lost;           ///< force of the motor, and of all that dissipates, at the last step
    P motor_work, lost_work; ///< sums since the start, J
};

/// Force along an axis, and the energy of its springs.
template <class P> struct AxisForce { P force, energy; };

namespace detail {

/// x, or with its sign the limit.
template <int W> SKEIN_INLINE Pack<W> limited(const Pack<W>& x, double most) {
    return max(min(x, Pack<W>(most)), Pack<W>(-most));
}

/// An angle within a turn from another one.
template <int W> SKEIN_INLINE Pack<W> wrapped(const Pack<W>& angle) {
    constexpr double turn = 6.283185307179586;
    Pack<W> x = angle;
    for (int n = 0; n < 2; ++n) {
        x = select(x > Pack<W>(0.5 * turn), x - Pack<W>(turn), x);
        x = select(x < Pack<W>(-0.5 * turn), x + Pack<W>(turn), x);
    }
    return x;
}

} // namespace detail

/// Force of a motor; `off`: distance from its position.
template <int W>
SKEIN_INLINE Pack<W> motor_force(const Motor& motor, const MotorNow& now, const Pack<W>& rate, const Pack<W>& off) {
    using P = Pack<W>;
    P force(0.0);
    switch (motor.kind) {
    case MotorKind::none:
        break;
    case MotorKind::position:
        force = P(-motor.stiffness) * off + P(motor.damping) * (P(now.rate) - rate);
        break;
    case MotorKind::rate:
        force = P(motor.damping) * (P(now.value) - rate);
        break;
    case MotorKind::force:
        force = P(now.value);
        break;
    }
    return motor.most > 0 ? detail::limited<W>(force, motor.most) : force;
}

/// Force along a free axis that is at `q`. Rates follow from the positions of this step and the two before, so dashpots
/// are of second order; `lagging`: of half a step before, for the first step. `h`: s, since the last step. `off`:
/// distance from the motor's position. `figures`: of a copy half a step on, whose rate `lagging` is, and which takes
/// the works up to there.
template <bool Turns, int W> SKEIN_INLINE AxisForce<Pack<W>> axis_force(const AxisSpec& axis, const MotorNow& now,
                                                                        const Pack<W>& q, const Pack<W>& lagging,
                                                                        const Pack<W>& off, double h,
                                                                        AxisMemory<Pack<W>>& memory, bool figures) {
    using P = Pack<W>;
    const P none(0.0), half(0.5);
    const Mask<W> moved = memory.steps > none;
    const P last = select(moved, memory.position, q), held_at = select(moved, memory.anchor, q);
    const P way = Turns ? detail::wrapped<W>(q - last) : q - last;
    const P interval = half * (P(h) + select(moved, memory.interval, P(h)));
    const P before = select(moved, way / interval, lagging), // half a step before
        rate = figures ? lagging : before + select(memory.steps > P(1.0), half * (before - memory.rate), none);
    P force = none, lost = P(-axis.damping) * rate, energy = none;
    if (axis.spring > 0) {
        const P stretch = q - P(axis.spring_rest);
        force = P(-axis.spring) * stretch;
        energy = P(0.5 * axis.spring) * stretch * stretch;
    }
    if (!axis.limits.empty()) {
        const P below = max(P(axis.limits[0]) - q, none), above = max(q - P(axis.limits[1]), none);
        const P elastic = P(axis.stop_stiffness) * (below - above);
        const P up = select(below > none, max(elastic - P(axis.stop_damping) * rate, none), none),
                down = select(above > none, min(elastic - P(axis.stop_damping) * rate, none), none);
        force += elastic;
        lost += (up + down) - elastic;
        energy += P(0.5 * axis.stop_stiffness) * (below * below + above * above);
    }
    if (axis.friction > 0) {
        const auto apart = [](const P& x) { return Turns ? detail::wrapped<W>(x) : x; };
        const P held = P(-axis.friction_stiffness) * apart(q - held_at) - P(axis.friction_damping) * rate,
                friction = detail::limited<W>(held, axis.friction);
        const Mask<W> slips = abs(held) > P(axis.friction);
        const P anchor = select(slips, q + P(1 / axis.friction_stiffness) * friction, held_at);
        lost += friction;
        if (!figures) memory.anchor = anchor;
    } else if (!figures) memory.anchor = q; // a branch may add friction
    const P motor = motor_force<W>(axis.motor, now, rate, off);
    // Works are sums of mean force times way. The first way is the drift that led here.
    const P first = P(0.5 * h) * lagging;
    memory.motor_work += select(moved, half * (memory.motor + motor) * way, motor * first);
    memory.lost_work += select(moved, half * (memory.lost + lost) * way, lost * first);
    if (!figures) {
        memory.position = q;
        memory.rate = before;
        memory.interval = P(h);
        memory.steps = min(memory.steps + P(1.0), P(2.0));
        memory.motor = motor;
        memory.lost = lost;
    }
    return {force + lost + motor, energy};
}

/// Angle between two frames about an axis of the second one.
template <class P> struct TurnAbout {
    P angle, off;  ///< from 0, and from another angle; between -pi and pi
    Vec3<P> slope; ///< d angle/d turn of the second frame, body
};
template <int W> SKEIN_INLINE TurnAbout<Pack<W>>
turn_about(const Quaternion<Pack<W>>& frame, const Quaternion<Pack<W>>& rest, const Vec3<Pack<W>>& axis, double other) {
    using P = Pack<W>;
    const P none(0.0), one(1.0);
    const Quaternion<P> r = frame * inverse(rest);
    const P s = dot(r.v, axis), inv = one / (r.w * r.w + s * s), root = sqrt(inv);
    const Vec3<P> slope = inv * (r.w * (r.w * axis + cross(axis, r.v)) + s * r.v);
    const auto angle = [&](const P& cosine, const P& sine) {
        const P sign = select(cosine < none, P(-1.0), one) * root;
        const Quaternion<P> unit{sign * cosine, {sign * sine, none, none}}, still{one, {none, none, none}};
        return relative_rotation(unit, still).x;
    };
    const P c(std::cos(0.5 * other)), t(std::sin(0.5 * other));
    return {angle(r.w, s), angle(r.w * c + s * t, s * c - r.w * t), slope};
}

/// A joint at a time: its laws, the motor, and the time since the last step.
struct AxisAt {
    const JointLaw& law;
    const AxisSpec& axis;
    MotorNow now;
    double h; ///< s
};

namespace detail {

/// Adds what keeps two axes at right angles.
template <int W> SKEIN_INLINE void add_universal(const AxisAt& at, const JoinedElement<Pack<W>>& a,
                                                 const JoinedElement<Pack<W>>& b, JointLoad<Pack<W>>& load,
                                                 JointLoad<Pack<W>>& other, JointFigures<Pack<W>>* figures) {
    using P = Pack<W>;
    const Vec3<P> n = transpose_times(a.director, a.axis), m = transpose_times(b.director, b.axis), about = cross(n, m),
                  turning = transpose_times(a.director, a.spin) - transpose_times(b.director, b.spin);
    const P cosine = dot(n, m);
    const Vec3<P> couple =
        (P(at.law.torsional_stiffness) * cosine + P(at.law.torsional_damping) * dot(turning, about)) * about;
    load.couple += a.director * (-couple);
    other.couple += b.director * couple;
    if (figures) figures->energy += P(0.5 * at.law.torsional_stiffness) * cosine * cosine;
}

/// Adds the springs and dashpots along and about the axes of the first element.
template <int W> SKEIN_INLINE void add_bushing(const AxisAt& at, const JoinedElement<Pack<W>>& a,
                                               const JoinedElement<Pack<W>>& b, const Quaternion<Pack<W>>& rest,
                                               JointLoad<Pack<W>>& load, JointLoad<Pack<W>>& other,
                                               JointFigures<Pack<W>>* figures) {
    using P = Pack<W>;
    const P half(0.5);
    const Vec3<P> along = broadcast<W>(at.law.along), about = broadcast<W>(at.law.about);
    const Vec3<P> wa = transpose_times(a.director, a.spin), wb = transpose_times(b.director, b.spin),
                  ra = transpose_times(a.director, a.arm), rb = transpose_times(b.director, b.arm);
    const Vec3<P> d = (between(b.share_before, b.share, b.node, b.next) + rb) -
                      (between(a.share_before, a.share, a.node, a.next) + ra);
    const Vec3<P> va = between(a.share_before, a.share, a.velocity, a.next_velocity) + cross(wa, ra),
                  vb = between(b.share_before, b.share, b.velocity, b.next_velocity) + cross(wb, rb);
    const Vec3<P> way = a.director * d, rate = a.director * ((vb - va) - cross(wa, d));
    const Vec3<P> pull = scale(along, P(at.law.stiffness) * way + P(at.law.damping) * rate);
    const Vec3<P> force = transpose_times(a.director, pull);
    const RelativeRotation<P> turn = relative_rotation_and_jacobian(inverse(rest) * b.director, a.director);
    const Vec3<P> tau = P(at.law.torsional_stiffness) * scale(about, turn.log), across = cross(turn.log, tau),
                  straight = tau + turn.jacobian * cross(turn.log, across);
    const Vec3<P> drag = P(at.law.torsional_damping) * scale(about, a.director * (wb - wa));
    load.force += force;
    load.couple += a.director * cross(ra + d, force) + (straight + half * across) + drag;
    other.force += -force;
    other.couple +=
        b.director * (cross(rb, -force) - transpose_times(a.director, drag)) + rest * (half * across - straight);
    if (figures) {
        const P spring = P(at.law.stiffness) * dot(way, scale(along, way));
        *figures = {figures->energy + half * (spring + dot(turn.log, tau)), sqrt(dot(d, d))};
    }
}

/// Adds the couple about the axis of a hinge.
template <int W> SKEIN_INLINE void add_turn(const AxisAt& at, const JoinedElement<Pack<W>>& a,
                                            const JoinedElement<Pack<W>>& b, const Quaternion<Pack<W>>& rest,
                                            AxisMemory<Pack<W>>& memory, JointLoad<Pack<W>>& load,
                                            JointLoad<Pack<W>>& other, JointFigures<Pack<W>>* figures) {
    using P = Pack<W>;
    const TurnAbout<P> now = turn_about<W>(b.director, rest * a.director, b.axis, at.now.value);
    const Vec3<P> slope = transpose_times(b.director, now.slope),
                  turning = transpose_times(b.director, b.spin) - transpose_times(a.director, a.spin);
    const AxisForce<P> q =
        axis_force<true, W>(at.axis, at.now, now.angle, dot(slope, turning), now.off, at.h, memory, figures != nullptr);
    const Vec3<P> couple = q.force * slope;
    load.couple += a.director * (-couple);
    other.couple += b.director * couple;
    if (figures) figures->energy += q.energy;
}

/// Adds the forces of a slider, or of a distance.
template <JointForm Form, int W> SKEIN_INLINE void add_way(const AxisAt& at, const JoinedElement<Pack<W>>& a,
                                                           const JoinedElement<Pack<W>>& b, const Pack<W>& length,
                                                           AxisMemory<Pack<W>>& memory, JointLoad<Pack<W>>& load,
                                                           JointLoad<Pack<W>>& other, JointFigures<Pack<W>>* figures) {
    using P = Pack<W>;
    const Vec3<P> wa = transpose_times(a.director, a.spin), wb = transpose_times(b.director, b.spin),
                  ra = transpose_times(a.director, a.arm), rb = transpose_times(b.director, b.arm);
    const Vec3<P> d = (between(b.share_before, b.share, b.node, b.next) + rb) -
                      (between(a.share_before, a.share, a.node, a.next) + ra);
    const Vec3<P> va = between(a.share_before, a.share, a.velocity, a.next_velocity) + cross(wa, ra),
                  vb = between(b.share_before, b.share, b.velocity, b.next_velocity) + cross(wb, rb);
    const auto along = [&](const P& way, const P& rate) {
        return axis_force<false, W>(at.axis, at.now, way, rate, way - P(at.now.value), at.h, memory,
                                    figures != nullptr);
    };
    const auto add = [&](const Vec3<P>& on_a, const Vec3<P>& lever_b) {
        load.force += on_a;
        load.couple += a.director * cross(ra, on_a);
        other.force += -on_a;
        other.couple += b.director * cross(lever_b, -on_a);
    };
    if constexpr (Form == JointForm::slider) {
        const Vec3<P> n = transpose_times(b.director, b.axis), u = (vb - va) - cross(wb, d);
        const P way = dot(n, d), rate = dot(n, u);
        const Vec3<P> across = d - way * n;
        const AxisForce<P> q = along(way, rate);
        add(P(at.law.stiffness) * across + P(at.law.damping) * (u - rate * n) - q.force * n, rb - d);
        if (figures)
            *figures = {figures->energy + q.energy + P(0.5 * at.law.stiffness) * dot(across, across),
                        sqrt(dot(across, across))};
    } else {
        const P far = sqrt(dot(d, d)), none(0.0);
        const Vec3<P> e = (P(1.0) / max(far, P(1e-150))) * d;
        const P stretch = far - length, rate = dot(e, vb - va), held = at.law.rope ? max(stretch, none) : stretch;
        P force = P(-at.law.stiffness) * held - P(at.law.damping) * rate;
        if (at.law.rope) force = select(stretch > none, min(force, none), none);
        const AxisForce<P> q = along(stretch, rate);
        add((-(force + q.force)) * e, rb);
        if (figures) *figures = {figures->energy + q.energy + P(0.5 * at.law.stiffness) * held * held, abs(held)};
    }
}

} // namespace detail

/// Loads on the first element of a joint of this form; those on the second go to `other`.
template <JointForm Form, int W>
SKEIN_INLINE JointLoad<Pack<W>> form_load(const AxisAt& at, const JoinedElement<Pack<W>>& a,
                                          const JoinedElement<Pack<W>>& b, const Quaternion<Pack<W>>& rest,
                                          const Pack<W>& length, AxisMemory<Pack<W>>& memory, JointLoad<Pack<W>>& other,
                                          JointFigures<Pack<W>>* figures = nullptr) {
    constexpr JointTurn turn = Form == JointForm::hinge    ? JointTurn::hinge
                               : Form == JointForm::slider ? JointTurn::fixed
                                                           : JointTurn::none;
    JointLaw base = at.law;
    if (Form == JointForm::slider || Form == JointForm::distance || Form == JointForm::bushing)
        base.stiffness = base.damping = 0;
    JointLoad<Pack<W>> load = joint_load<turn, true, false, W>(base, a, b, rest, length, other, figures);
    if constexpr (Form == JointForm::universal) detail::add_universal<W>(at, a, b, load, other, figures);
    else if constexpr (Form == JointForm::bushing) detail::add_bushing<W>(at, a, b, rest, load, other, figures);
    else if constexpr (Form == JointForm::hinge) detail::add_turn<W>(at, a, b, rest, memory, load, other, figures);
    else detail::add_way<Form, W>(at, a, b, length, memory, load, other, figures);
    return load;
}

} // namespace skein
