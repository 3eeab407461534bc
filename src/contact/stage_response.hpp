// Forces of a wall on a point over a stage of an implicit step, and their slopes.                theory.md (132)-(134)
//   overlaps    g0 at the start of the stage, g1 at its end, g where loads are evaluated;  d = max(0, g) of each
//   share       s = (d1 - d0)/(g1 - g0), 1 where both touch: part of the stage in contact
//   normal      N = U'(g1), or where steps keep energy (U(g1) - U(g0))/(g1 - g0);  the dashpot adds c u_n s
//   friction    laws of response.hpp in the state and with the rates of the stage, without the spring by which explicit
//               steps regularise friction
//   slopes      S = dF/d(displacement of the contact), with rates that change by the displacement over h
// Trials leave the memory of the contact as it is. The end of a stage advances it over the time of the whole stage.
#pragma once

#include "contact/response.hpp"

namespace skein {

/// Overlaps of a point over a stage, m. Theirs are of one straight way: g1 - g0 is the way of the point towards the
/// wall.
template <class P> struct StageOverlap {
    P start, now, end;
    bool between; ///< the force stands for the way from start to end, else for the end, which is now
};

/// Times of a stage, s: from displacement to rate; whole, over which memory advances.
template <class P> struct StageTimes { P rate, whole; };

/// Loads of a stage on a point, and what it does to the memory.
template <class P> struct StageContact {
    Vec3<P> on_point;                  ///< N
    Vec3<P> moment;                    ///< n x T, N
    P arm;                             ///< m
    P normal;                          ///< N
    P stiffness;                       ///< of the normal spring, N/m
    P elastic_energy;                  ///< J
    P friction_work{}, viscous_work{}; ///< of the whole stage, J; where memory advances
    P slopes[3][3];                    ///< N/m
};

namespace detail {

/// Elastic normal force of a stage, its slope by the overlap now, share of the stage, and root of the overlap.
template <class P> struct StageNormal { P force, slope, share, root; };

template <class P> SKEIN_INLINE StageNormal<P> stage_normal(bool hertz, const P& k, const StageOverlap<P>& g) {
    const P zero(0.0), half(0.5), one(1.0), two(2.0), tiny(1e-300);
    const P from = max(g.start, zero), to = max(g.end, zero), way = g.end - g.start;
    const auto both = (g.start > zero) & (g.end > zero), either = (g.start > zero) | (g.end > zero);
    const P share = select(both, one, select(either, (to - from) / select(abs(way) > tiny, way, one), zero));
    if (!g.between) {
        const P root = hertz ? sqrt(to) : one;
        const auto touches = g.end > zero;
        return {root * (k * to), select(touches, (hertz ? P(1.5) : one) * root * k, zero), share, root};
    }
    const auto ends = g.end > zero;
    if (!hertz) {
        const P force = half * k * (from + to) * share;
        const P mixed = (select(ends, k * to, zero) - force) / select(abs(way) > tiny, way, one);
        return {force, two * select(both, half * k, select(either, mixed, zero)), share, one};
    }
    const P p = sqrt(from), q = sqrt(to), sum = max(p + q, P(1e-150));
    const P quartic = (q * q) * (q * q) + (q * q) * (q * p) + (q * p) * (q * p) + (q * p) * (p * p) + (p * p) * (p * p);
    const P over = P(0.4) * k / sum, force = over * quartic * share;
    const P cubic = P(4.0) * (q * q * q) + P(3.0) * (q * q) * p + two * q * (p * p) + p * p * p;
    const P inside = over * (cubic - quartic / sum) / max(two * q, P(1e-150));
    const P mixed = (k * to * q - force) / select(abs(way) > tiny, way, one);
    return {force, two * select(both, inside, select(either, mixed, zero)), share, half * sum * share};
}

/// Adds `by` times a column and a line.
template <class P>
SKEIN_INLINE void add_product(P (&to)[3][3], const P& by, const Vec3<P>& column, const Vec3<P>& line) {
    const P c[3] = {by * column.x, by * column.y, by * column.z}, l[3] = {line.x, line.y, line.z};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) to[i][j] = fma(c[i], l[j], to[i][j]);
}
/// Adds `by` times the projection across n.
template <class P> SKEIN_INLINE void add_across(P (&to)[3][3], const P& by, const Vec3<P>& n) {
    for (int i = 0; i < 3; ++i) to[i][i] += by;
    add_product(to, -by, n, n);
}

/// Slopes of friction; `slope`: of the normal force.
template <int W> SKEIN_INLINE void add_friction_slopes(Pack<W> (&to)[3][3], ContactKinds kinds,
                                                       const ContactNumbers<Pack<W>>& law, const Sliding<W>& in,
                                                       const ContactMemory<Pack<W>>& last, const Vec3<Pack<W>>& force,
                                                       const Pack<W>& slope, const Lie<Pack<W>>* lie,
                                                       const Pack<W>& time) {
    using P = Pack<W>;
    const P zero(0.0), one(1.0), tiny(1e-150), rate = one / time;
    const Vec3<P>& n = in.normal;
    if (kinds.friction == ContactFriction::none) return;
    if (kinds.friction == ContactFriction::memory) {
        const P stiffness = min(law.tangential_stiffness * in.root, law.stiffest_tangential);
        const P kept =
            kinds.normal == ContactNormal::hertz ? min(one, last.spring.stiffness / max(stiffness, tiny)) : one;
        const Vec3<P> x = fma(in.step, in.tangential, in.in_plane(kept * last.spring.x)),
                      trial = -(stiffness * x) - law.tangential_damping * in.tangential;
        const P squared = dot(trial, trial), limit = law.static_friction * in.pressed,
                q = fma(rate, law.tangential_damping, stiffness);
        const auto sticks = squared <= limit * limit;
        const P inverse = one / max(sqrt(squared), tiny), slides = law.kinetic_friction * in.pressed * inverse * q;
        const Vec3<P> along = inverse * trial;
        add_across(to, -select(sticks, q, slides), n);
        add_product(to, select(sticks, zero, slides), along, along);
        add_product(to, select(sticks, zero, law.kinetic_friction * slope), along, n);
        return;
    }
    const P speed = norm(in.tangential), pressed = max(in.pressed, tiny);
    add_product(to, slope / pressed, force, n);
    const Vec3<P> along = (one / max(speed, tiny)) * in.tangential;
    const P most = law.kinetic_friction * in.pressed * rate;
    if (kinds.friction == ContactFriction::published) {
        const P rise = P(0.5) * law.slip_speed, share = min(max((speed - law.slip_speed) / max(rise, tiny), zero), one);
        const auto rises = (share > zero) & (share < one);
        const P across = most * share / max(speed, tiny), with = select(rises, most / max(rise, tiny), zero);
        add_across(to, -across, n);
        add_product(to, across - with, along, along);
        return;
    }
    const P fastest = max(max(speed, law.slip_speed), tiny), by = most / fastest;
    const P slips = select(speed > law.slip_speed, by, zero);
    if (!lie) {
        add_across(to, -by, n);
        add_product(to, slips, along, along);
        return;
    }
    const Vec3<P> flat = lie->axis - dot(lie->axis, n) * n, axis = (one / max(norm(flat), tiny)) * flat;
    const P forward = select(dot(in.tangential, flat) > zero, one, lie->backward), more = forward - lie->sideways;
    add_across(to, -(by * lie->sideways), n);
    add_product(to, -(by * more), axis, axis);
    const Vec3<P> resisted = lie->sideways * along + (more * dot(along, axis)) * axis;
    add_product(to, slips, resisted, along);
}

} // namespace detail

/// Loads at a point that a wall touches in a stage. `in`: state where loads are evaluated, whose distance is not read;
/// `turned`: normal force along n over that of a straight way. `memory` advances if `ends`.
template <int W>
SKEIN_INLINE StageContact<Pack<W>> stage_contact(ContactKinds kinds, const ContactNumbers<Pack<W>>& law,
                                                 const ContactState<Pack<W>>& in, const StageOverlap<Pack<W>>& overlap,
                                                 const Pack<W>& turned, const StageTimes<Pack<W>>& times, bool ends,
                                                 ContactMemory<Pack<W>>& memory, const Lie<Pack<W>>* lie) {
    using P = Pack<W>;
    const P zero(0.0), half(0.5);
    const bool hertz = kinds.normal == ContactNormal::hertz;
    const Vec3<P>& n = in.normal;
    const auto elastic = detail::stage_normal(hertz, law.stiffness, overlap);
    StageContact<P> out;
    out.arm = fnma(half, overlap.now, in.radius_1);
    const Vec3<P> slip = in.velocity_1 - in.velocity_2 + cross(out.arm * in.spin_1, n);
    const P approach = dot(slip, n), dashpot = law.damping * elastic.root;
    const Vec3<P> tangential = slip - approach * n;
    const auto touches = elastic.share > zero;
    out.normal = select(touches, max(fma(dashpot * elastic.share, approach, elastic.force), zero), zero);
    const auto enters = overlap.end > zero;
    const P slope = select(out.normal > zero, elastic.slope + select(enters, dashpot / times.rate, zero), zero);
    out.stiffness = elastic.slope;
    const auto sliding_over = [&](const P& time) {
        return detail::Sliding<W>{n,
                                  tangential,
                                  (half * time) * tangential,
                                  time,
                                  half * time * dot(in.spin_1, n),
                                  out.normal,
                                  elastic.root,
                                  P(1.0),
                                  touches};
    };
    ContactForce<P> unused{};
    const auto sliding = sliding_over(times.rate);
    const Vec3<P> friction = detail::add_friction<W>(kinds, law, sliding, memory, lie, unused).force;
    for (auto& line : out.slopes)
        for (P& entry : line) entry = zero;
    detail::add_product(out.slopes, -(slope * turned), n, n);
    detail::add_friction_slopes<W>(out.slopes, kinds, law, sliding, memory, friction, slope, lie, times.rate);
    out.moment = cross(n, friction);
    out.on_point = friction - (out.normal * turned) * n;
    const P depth = max(overlap.now, zero), whole = times.whole;
    out.elastic_energy = P(hertz ? 0.4 : 0.5) * (hertz ? sqrt(depth) : P(1.0)) * (law.stiffness * depth) * depth;
    if (!ends) return out;
    ContactMemory<P> now = detail::add_friction<W>(kinds, law, sliding_over(times.whole), memory, lie, unused).memory;
    const P before = memory.energy(),
            dashed = kinds.friction == ContactFriction::memory ? -(whole * dot(now.viscous_part, tangential)) : zero;
    out.friction_work = before - now.energy() - dashed - whole * dot(friction, tangential);
    out.viscous_work = dashed + whole * (out.normal - elastic.force) * approach;
    now.viscous_part = select(touches, now.viscous_part, Vec3<P>{zero, zero, zero});
    out.elastic_energy += now.energy();
    memory = now;
    return out;
}

} // namespace skein
