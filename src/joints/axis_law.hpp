// Laws of joints with free axes, W at a time: the angle of a hinge, the way of a slider, the length of a distance, both
// angles of a universal joint, the turn of a spherical one.
//                                                                                        theory.md (73f)-(73h)
//   hinge      angle q = 2 atan2(v.n, w),  (w, v) = Q2 (C Q1)^T;  couple Q G on 2, -Q G on 1,  G = dq/d(turn of 2)
//   slider     way q = n2.d;  force Q n2 on 2 and -Q n2 on 1, both at the point of 1; across it the point spring acts
//   distance   q = |d| - L;  force Q d/|d| on 2, and the opposite on 1
//   bushing    d and phi in the frame of 1:  F = K d + N u on 1 at the point of 2,  u of 2's point against 1;
//              couples of K_t phi as of a cell (15), and N_t (w2 - w1);  K, N, K_t, N_t diagonal
//   universal  two axes stay at right angles: U = k_t (n1.m2)^2/2; the angle of m2 about n1 in 1, less that of n1 about
//              m2 in 2
//   ball       R = Q2 (C Q1)^T: spring and friction by logarithms, a cone and stops of the twist about an axis
//   Q          spring, dashpot, stops, dry friction with memory, motor; an angle counts whole turns
#pragma once

#include "joints/axis_spec.hpp"
#include "joints/joint_law.hpp"
#include "joints/joint_spec.hpp"

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
    P turns;                 ///< whole turns of an angle, which is within half a turn besides; before a first step too
};

/// Memory of a spherical joint, whose couples and rates are in the axes of the second side.
template <class P> struct BallMemory {
    Quaternion<P> anchor; ///< turn at which the spring of friction has no couple
    Quaternion<P> turn;   ///< of the last step
    Vec3<P> rate;         ///< half a step before the last turn
    P steps;              ///< made so far, up to 2
    P interval;           ///< length of the last step, s
    Vec3<P> motor, lost;
    P motor_work, lost_work;
};

/// Memory of free axes: of the first, and what joints with more of them have besides, or null.
template <class P> struct AxesMemory {
    AxisMemory<P>& first;
    P* more;
};
/// Numbers of the latter.
inline std::size_t more_memory_numbers(const JointSpec& spec) {
    if (!spec.has_axes()) return 0;
    return spec.kind == JointKind::universal   ? sizeof(AxisMemory<double>) / sizeof(double)
           : spec.kind == JointKind::spherical ? sizeof(BallMemory<double>) / sizeof(double)
                                               : 0;
}
inline constexpr std::size_t most_more_memory = sizeof(BallMemory<double>) / sizeof(double);
static_assert(sizeof(AxisMemory<double>) <= sizeof(BallMemory<double>));

/// State that joints are evaluated at, and whether they remember it.
enum class JointTime {
    staggered, ///< the middle of an explicit step: rates are half a step older than places
    trial,     ///< within an implicit step, with its own rates; nothing is remembered
    end,       ///< the end of an implicit step, likewise, which is remembered
};

/// Force along an axis, and the energy of its springs.
template <class P> struct AxisForce { P force, energy; };

namespace detail {

/// x, or with its sign the limit.
template <int W> SKEIN_INLINE Pack<W> limited(const Pack<W>& x, double most) {
    return max(min(x, Pack<W>(most)), Pack<W>(-most));
}

inline constexpr double whole_turn = 6.283185307179586; // rad

/// An angle within a turn from another one.
template <int W> SKEIN_INLINE Pack<W> wrapped(const Pack<W>& angle) {
    constexpr double turn = whole_turn;
    Pack<W> x = angle;
    for (int n = 0; n < 2; ++n) {
        x = select(x > Pack<W>(0.5 * turn), x - Pack<W>(turn), x);
        x = select(x < Pack<W>(-0.5 * turn), x + Pack<W>(turn), x);
    }
    return x;
}

/// The nearest whole number.
template <int W> SKEIN_INLINE Pack<W> rounded(const Pack<W>& x) {
    constexpr double shift = 6755399441055744.0; // 1.5 * 2^52: beyond it numbers have no fractions
    return (x + Pack<W>(shift)) - Pack<W>(shift);
}

/// An angle and whole turns; the same bits where there are none.
template <int W> SKEIN_INLINE Pack<W> with_turns(const Pack<W>& angle, const Pack<W>& turns) {
    return select(abs(turns) > Pack<W>(0.5), angle + Pack<W>(whole_turn) * turns, angle);
}

/// Energy and forces of stops that an axis meets at `low` and `high`.
template <class P> struct StopForce { P elastic, total, energy; };
template <int W> SKEIN_INLINE StopForce<Pack<W>> stop_force(const AxisSpec& axis, double low, double high,
                                                            const Pack<W>& at, const Pack<W>& rate) {
    using P = Pack<W>;
    const P none(0.0), below = max(P(low) - at, none), above = max(at - P(high), none);
    const P elastic = P(axis.stop_stiffness) * (below - above);
    const P up = select(below > none, max(elastic - P(axis.stop_damping) * rate, none), none),
            down = select(above > none, min(elastic - P(axis.stop_damping) * rate, none), none);
    return {elastic, up + down, P(0.5 * axis.stop_stiffness) * (below * below + above * above)};
}

/// The angle of a direction with these components along and across another one.
template <int W> SKEIN_INLINE Pack<W> angle_of(const Pack<W>& along, const Pack<W>& across) {
    using P = Pack<W>;
    const P none(0.0), one(1.0), length = sqrt(along * along + across * across);
    const Mask<W> behind = along < none;
    const P cosine = select(behind, abs(across), length + along), // of half the angle
        sine = select(behind, select(across < none, along - length, length - along), across);
    const P scale = one / max(sqrt(cosine * cosine + sine * sine), P(1e-150));
    const Quaternion<P> unit{scale * cosine, {scale * sine, none, none}}, still{one, {none, none, none}};
    return relative_rotation(unit, still).x;
}

} // namespace detail

/// Force of a motor; `off`: distance from its position.
template <int W> SKEIN_INLINE Pack<W> motor_force(const Motor& motor, const MotorNow<Pack<W>>& now, const Pack<W>& rate,
                                                  const Pack<W>& off) {
    using P = Pack<W>;
    P force(0.0);
    switch (motor.kind) {
    case MotorKind::none:
        break;
    case MotorKind::position:
        force = P(-motor.stiffness) * off + P(motor.damping) * (now.rate - rate);
        break;
    case MotorKind::rate:
        force = P(motor.damping) * (now.value - rate);
        break;
    case MotorKind::force:
        force = now.value;
        break;
    }
    return motor.most > 0 ? detail::limited<W>(force, motor.most) : force;
}

/// A joint at a time: its laws, the motor, and the time since the last step.
template <class P> struct AxisAt {
    const JointLaw& law;
    const AxisSpec &axis, &second;
    MotorsNow<P> now;
    double h; ///< s
    bool to_world;
    JointTime time = JointTime::staggered;
};

/// Force along a free axis that is at `q`. Rates of staggered steps follow from the positions of this step and the two
/// before, so dashpots are of second order; `lagging`: rate of the state, which is then that of half a step before.
/// `off`: distance from the motor's position, of an angle but for whole turns. `figures`: of a copy half a step on,
/// whose rate `lagging` is, and which takes the works up to there.
template <bool Turns, int W>
SKEIN_INLINE AxisForce<Pack<W>> axis_force(const AxisAt<Pack<W>>& joint, const AxisSpec& axis,
                                           const MotorNow<Pack<W>>& now, const Pack<W>& q, const Pack<W>& lagging,
                                           const Pack<W>& off, AxisMemory<Pack<W>>& memory, bool figures) {
    using P = Pack<W>;
    const double h = joint.h;
    const bool staggered = joint.time == JointTime::staggered, remembers = !figures && joint.time != JointTime::trial;
    const P none(0.0), half(0.5);
    const Mask<W> moved = memory.steps > none;
    const P last = select(moved, memory.position, q);
    const P way = Turns ? detail::wrapped<W>(q - last) : q - last;
    const P over = way - (q - last),
            turns = Turns ? memory.turns + detail::rounded<W>(P(1 / detail::whole_turn) * over) : none,
            at = Turns ? detail::with_turns<W>(q, turns) : q;
    const P interval = half * (P(h) + select(moved, memory.interval, P(h)));
    const P before = select(moved, way / interval, lagging), // half a step before
        rate = figures || !staggered ? lagging
                                     : before + select(memory.steps > P(1.0), half * (before - memory.rate), none);
    P force = none, lost = P(-axis.damping) * rate, energy = none;
    if (axis.spring > 0) {
        const P stretch = at - P(axis.spring_rest);
        force = P(-axis.spring) * stretch;
        energy = P(0.5 * axis.spring) * stretch * stretch;
    }
    if (!axis.limits.empty()) {
        const detail::StopForce<P> stop = detail::stop_force<W>(axis, axis.limits[0], axis.limits[1], at, rate);
        force += stop.elastic;
        lost += stop.total - stop.elastic;
        energy += stop.energy;
    }
    if (axis.friction > 0) {
        const P held_at = select(moved, memory.anchor, at),
                held = P(-axis.friction_stiffness) * (at - held_at) - P(axis.friction_damping) * rate,
                friction = detail::limited<W>(held, axis.friction);
        const Mask<W> slips = abs(held) > P(axis.friction);
        const P anchor = select(slips, at + P(1 / axis.friction_stiffness) * friction, held_at);
        lost += friction;
        if (remembers) memory.anchor = anchor;
    } else if (remembers) memory.anchor = at; // a branch may add friction
    const P behind = at - now.value - off;    // whole turns that `off` does not count
    const P distance = Turns ? detail::with_turns<W>(off, detail::rounded<W>(P(1 / detail::whole_turn) * behind)) : off;
    const P motor = motor_force<W>(axis.motor, now, rate, distance);
    if (joint.time == JointTime::trial) return {force + lost + motor, energy};
    // Works are sums of mean force times way. The first way is the drift that led here.
    const P first = P(0.5 * h) * lagging;
    memory.motor_work += select(moved, half * (memory.motor + motor) * way, motor * first);
    memory.lost_work += select(moved, half * (memory.lost + lost) * way, lost * first);
    if (remembers) {
        memory.position = q;
        memory.turns = turns;
        memory.rate = staggered ? before : rate;
        memory.interval = P(h);
        memory.steps = min(memory.steps + P(1.0), P(2.0));
        memory.motor = motor;
        memory.lost = lost;
    }
    return {force + lost + motor, energy};
}

/// Angle between two frames about an axis of the second one. c, t: cosine and sine of half the other angle.
template <class P> struct TurnAbout {
    P angle, off;  ///< from 0, and from another angle; between -pi and pi
    Vec3<P> slope; ///< d angle/d turn of the second frame, body
};
template <int W> SKEIN_INLINE TurnAbout<Pack<W>> turn_about(const Quaternion<Pack<W>>& frame,
                                                            const Quaternion<Pack<W>>& rest, const Vec3<Pack<W>>& axis,
                                                            const Pack<W>& c, const Pack<W>& t) {
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
    return {angle(r.w, s), angle(r.w * c + s * t, s * c - r.w * t), slope};
}

namespace detail {

/// Adds what keeps two axes at right angles.
template <int W> SKEIN_INLINE void add_universal(const AxisAt<Pack<W>>& at, const JoinedElement<Pack<W>>& a,
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
template <int W> SKEIN_INLINE void add_bushing(const AxisAt<Pack<W>>& at, const JoinedElement<Pack<W>>& a,
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
template <int W> SKEIN_INLINE void add_turn(const AxisAt<Pack<W>>& at, const JoinedElement<Pack<W>>& a,
                                            const JoinedElement<Pack<W>>& b, const Quaternion<Pack<W>>& rest,
                                            AxisMemory<Pack<W>>& memory, JointLoad<Pack<W>>& load,
                                            JointLoad<Pack<W>>& other, JointFigures<Pack<W>>* figures) {
    using P = Pack<W>;
    const TurnAbout<P> now = turn_about<W>(b.director, rest * a.director, b.axis, at.now.cosine, at.now.sine);
    const Vec3<P> slope = transpose_times(b.director, now.slope),
                  turning = transpose_times(b.director, b.spin) - transpose_times(a.director, a.spin);
    const AxisForce<P> q = axis_force<true, W>(at, at.axis, at.now.first(), now.angle, dot(slope, turning), now.off,
                                               memory, figures != nullptr);
    const Vec3<P> couple = q.force * slope;
    load.couple += a.director * (-couple);
    other.couple += b.director * couple;
    if (figures) figures->energy += q.energy;
}

/// Adds the couples about both axes of a universal joint.
template <int W> SKEIN_INLINE void add_two_turns(const AxisAt<Pack<W>>& at, const JoinedElement<Pack<W>>& a,
                                                 const JoinedElement<Pack<W>>& b, const Quaternion<Pack<W>>& rest,
                                                 AxesMemory<Pack<W>> memory, JointLoad<Pack<W>>& load,
                                                 JointLoad<Pack<W>>& other, JointFigures<Pack<W>>* figures) {
    using P = Pack<W>;
    const Vec3<P> n = transpose_times(a.director, a.axis), m = transpose_times(b.director, b.axis);
    const Vec3<P> turning = transpose_times(b.director, b.spin) - transpose_times(a.director, a.spin);
    const auto add = [&](const AxisSpec& axis, const MotorNow<Pack<W>>& now, const Vec3<P>& about, const Vec3<P>& start,
                         const Vec3<P>& moving, double sign, AxisMemory<P>& own) {
        const Vec3<P> across = cross(about, start);
        const P x = dot(moving, start), y = dot(moving, across);
        const Vec3<P> slope = (P(1.0) / (x * x + y * y)) * cross(moving, x * across - y * start);
        const P angle = P(sign) * angle_of<W>(x, y);
        const AxisForce<P> q =
            axis_force<true, W>(at, axis, now, angle, dot(slope, turning), angle - now.value, own, figures != nullptr);
        const Vec3<P> couple = q.force * slope;
        load.couple += a.director * (-couple);
        other.couple += b.director * couple;
        if (figures) figures->energy += q.energy;
    };
    // The second axis turns about the first in 1. In 2 the first turns about the second the other way.
    add(at.axis, at.now.first(), n, transpose_times(a.director, transpose_times(rest, b.axis)), m, 1, memory.first);
    add(at.second, at.now.second(), m, transpose_times(b.director, rest * a.axis), n, -1,
        *reinterpret_cast<AxisMemory<P>*>(memory.more));
}

/// A vector no longer than the limit.
template <int W> SKEIN_INLINE Vec3<Pack<W>> no_longer(const Vec3<Pack<W>>& v, double most) {
    using P = Pack<W>;
    const P length = sqrt(dot(v, v));
    return select(length > P(most), P(most) / max(length, P(1e-150)), P(1.0)) * v;
}

/// Couple of a spherical joint's motor on the second side, in its axes, as are `turn` of it against the first, and
/// `rate`. n and u are its directions.
template <int W> SKEIN_INLINE Vec3<Pack<W>> ball_motor(const AxisAt<Pack<W>>& at, const Quaternion<Pack<W>>& turn,
                                                       const Vec3<Pack<W>>& rate, const Vec3<Pack<W>>& n,
                                                       const Vec3<Pack<W>>& u) {
    using P = Pack<W>;
    const Motor& motor = at.axis.motor;
    const auto own = [&](const Vec3<P>& v) { return v.x * n + v.y * u + v.z * cross(n, u); };
    const auto carried = [&](const Vec3<P>& v) { return at.to_world ? v : turn * v; };
    const Vec3<P> value = own(at.now.value);
    Vec3<P> couple{};
    switch (motor.kind) {
    case MotorKind::none:
        return couple;
    case MotorKind::position:
        couple = P(-motor.stiffness) * relative_rotation(turn, rotation(value)) +
                 P(motor.damping) * (own(at.now.rate) - rate);
        break;
    case MotorKind::rate:
        couple = P(motor.damping) * (carried(value) - rate);
        break;
    case MotorKind::force:
        couple = carried(value);
        break;
    }
    return motor.most > 0 ? no_longer<W>(couple, motor.most) : couple;
}

/// Adds the stops at the cone and the limits of the twist of a spherical joint about n, the axis in the second side.
/// The dissipative part goes to `lost`.
template <int W> SKEIN_INLINE void add_ball_stops(const AxisAt<Pack<W>>& at, const Quaternion<Pack<W>>& director,
                                                  const Quaternion<Pack<W>>& frame, const Vec3<Pack<W>>& n,
                                                  const Vec3<Pack<W>>& rate, Vec3<Pack<W>>& elastic,
                                                  Vec3<Pack<W>>& lost, Pack<W>& energy) {
    using P = Pack<W>;
    const auto add = [&](double low, double high, const P& angle, const Vec3<P>& slope) {
        const StopForce<P> stop = stop_force<W>(at.axis, low, high, angle, dot(slope, rate));
        elastic += stop.elastic * slope;
        lost += (stop.total - stop.elastic) * slope;
        energy += stop.energy;
    };
    if (at.law.cone > 0) {
        const Vec3<P> of_first = director * transpose_times(frame, n), about = cross(of_first, n);
        const P sine = sqrt(dot(about, about));
        add(-at.law.cone, at.law.cone, angle_of<W>(dot(of_first, n), sine), (P(1.0) / max(sine, P(1e-150))) * about);
    }
    if (!at.axis.limits.empty()) {
        const TurnAbout<P> twist = turn_about<W>(director, frame, n, P(1.0), P(0.0));
        add(at.axis.limits[0], at.axis.limits[1], twist.angle, twist.slope);
    }
}

/// Adds the couples of a spherical joint.
template <int W> SKEIN_INLINE void add_ball(const AxisAt<Pack<W>>& at, const JoinedElement<Pack<W>>& a,
                                            const JoinedElement<Pack<W>>& b, const Quaternion<Pack<W>>& rest,
                                            BallMemory<Pack<W>>& memory, JointLoad<Pack<W>>& load,
                                            JointLoad<Pack<W>>& other, JointFigures<Pack<W>>* figures) {
    using P = Pack<W>;
    const AxisSpec& axis = at.axis;
    const P none(0.0), one(1.0), half(0.5);
    const Quaternion<P> frame = rest * a.director, turn = b.director * inverse(frame);
    const Vec3<P> lagging = b.spin - b.director * transpose_times(a.director, a.spin);
    const Mask<W> moved = memory.steps > none;
    const Vec3<P> way = relative_rotation(turn, select(moved, memory.turn, turn));
    const P interval = half * (P(at.h) + select(moved, memory.interval, P(at.h)));
    const bool staggered = at.time == JointTime::staggered;
    const Vec3<P> before = select(moved, (one / interval) * way, lagging),
                  rate = figures || !staggered
                             ? lagging
                             : before + select(memory.steps > one, half * (before - memory.rate), Vec3<P>{});
    Vec3<P> elastic{}, lost = P(-axis.damping) * rate;
    P energy = none;
    if (axis.spring > 0) {
        const Vec3<P> phi = relative_rotation(b.director, frame);
        elastic = P(-axis.spring) * phi;
        energy = P(0.5 * axis.spring) * dot(phi, phi);
    }
    add_ball_stops<W>(at, b.director, frame, rest * a.axis, rate, elastic, lost, energy);
    Quaternion<P> anchor = turn; // a branch may add friction
    if (axis.friction > 0) {
        anchor = select(moved, memory.anchor, turn);
        const Vec3<P> held =
            P(-axis.friction_stiffness) * relative_rotation(turn, anchor) - P(axis.friction_damping) * rate;
        const Vec3<P> friction = no_longer<W>(held, axis.friction);
        const Mask<W> slips = dot(held, held) > P(axis.friction * axis.friction);
        anchor = select(slips, rotation(P(1 / axis.friction_stiffness) * friction) * turn, anchor);
        lost += friction;
    }
    const Vec3<P> motor = ball_motor<W>(at, turn, rate, rest * a.axis, rest * b.axis);
    const Vec3<P> couple = elastic + lost + motor;
    other.couple += couple;
    load.couple += a.director * (-transpose_times(b.director, couple));
    if (at.time == JointTime::trial) return;
    const Vec3<P> first = P(0.5 * at.h) * lagging; // the drift that led to the first step
    memory.motor_work += select(moved, half * dot(memory.motor + motor, way), dot(motor, first));
    memory.lost_work += select(moved, half * dot(memory.lost + lost, way), dot(lost, first));
    if (!figures) {
        memory.anchor = anchor;
        memory.turn = turn;
        memory.rate = staggered ? before : rate;
        memory.interval = P(at.h);
        memory.steps = min(memory.steps + one, P(2.0));
        memory.motor = motor;
        memory.lost = lost;
    } else figures->energy += energy;
}

/// Adds the forces of a slider, or of a distance.
template <JointForm Form, int W> SKEIN_INLINE void add_way(const AxisAt<Pack<W>>& at, const JoinedElement<Pack<W>>& a,
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
        return axis_force<false, W>(at, at.axis, at.now.first(), way, rate, way - at.now.value.x, memory,
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
SKEIN_INLINE JointLoad<Pack<W>> form_load(const AxisAt<Pack<W>>& at, const JoinedElement<Pack<W>>& a,
                                          const JoinedElement<Pack<W>>& b, const Quaternion<Pack<W>>& rest,
                                          const Pack<W>& length, AxesMemory<Pack<W>> memory, JointLoad<Pack<W>>& other,
                                          JointFigures<Pack<W>>* figures = nullptr) {
    constexpr JointTurn turn = Form == JointForm::hinge    ? JointTurn::hinge
                               : Form == JointForm::slider ? JointTurn::fixed
                                                           : JointTurn::none;
    JointLaw base = at.law;
    if (Form == JointForm::slider || Form == JointForm::distance || Form == JointForm::bushing)
        base.stiffness = base.damping = 0;
    JointLoad<Pack<W>> load = joint_load<turn, true, false, W>(base, a, b, rest, length, other, figures);
    if constexpr (Form == JointForm::universal) {
        detail::add_universal<W>(at, a, b, load, other, figures);
        if (memory.more) detail::add_two_turns<W>(at, a, b, rest, memory, load, other, figures);
    } else if constexpr (Form == JointForm::ball)
        detail::add_ball<W>(at, a, b, rest, *reinterpret_cast<BallMemory<Pack<W>>*>(memory.more), load, other, figures);
    else if constexpr (Form == JointForm::bushing) detail::add_bushing<W>(at, a, b, rest, load, other, figures);
    else if constexpr (Form == JointForm::hinge)
        detail::add_turn<W>(at, a, b, rest, memory.first, load, other, figures);
    else detail::add_way<Form, W>(at, a, b, length, memory.first, load, other, figures);
    return load;
}

} // namespace skein
