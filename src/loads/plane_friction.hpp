// A plane on which rods lie and slide with a friction of its own forth, back and sideways: snakes.
// Per element, N the plane's normal, a = unit(t - (t.N) N), b = a x N, arm -r N; touching where the gap g = d - r is at most
// `tolerance`
//   F = sum of nodal loads so far, half from each node (whole from end nodes)
//   push   P = max(0, -F.N);  plane force (P - k min(0, g) - c v.N) N;  friction goes by P alone
//   slip   v_a = v.a,  v_b = v.b + Q^T(w x Q arm).b;  phi(s) = 1 for |s| <= v_s, |2 - |s|/v_s| up to 2 v_s, 0 above
//   slides along  -(1 - phi_a) mu_k(sign v_a) P (u.a) a;  across -(1 - phi_b) mu_k,side P (u.b) b, couple arm x that;  u = unit(v_a
//   a + v_b b) holds  along  -clamp(F.a, -phi_a mu_s,back P, phi_a mu_s,forward P) a, F with sliding friction in it
//          across clamp(-(r F.b - 2 C.a)/(3 r), +- phi_b mu_s,side P) b, C the couple so far in the lab, couple arm x that
// Reads the loads already there, internal and external, so it comes after contacts and walls. The velocity is that of before the
// kick. theory.md (60)-(62)
// Source: Gazzola et al. 2018 (R. Soc. Open Sci. 5, 171628), as PyElastica has it. Cost: 330 flop per element.
#pragma once

#include "core/error.hpp"
#include "core/fields.hpp"
#include "rod/mapping.hpp"

#include <algorithm>
#include <numbers>
#include <vector>

namespace skein {

struct PlaneFriction {
    static constexpr std::string_view kind = "anisotropic_plane";
    static constexpr bool needs_whole_rods = true; ///< loads that other elements have not yet touched are read ahead
    static constexpr bool feels_all = true;

    Vec3d point{0, 0, 0};                                                   ///< m
    Vec3d normal{0, 0, 1};                                                  ///< towards the rods
    double stiffness = 0;                                                   ///< k, N/m
    double damping = 0;                                                     ///< c, N s/m
    double tolerance = 1e-4;                                                ///< m
    double kinetic_forward = 0, kinetic_backward = 0, kinetic_sideways = 0; ///< mu_k
    double static_forward = 0, static_backward = 0, static_sideways = 0;    ///< mu_s
    double slip_speed = 1e-8;                                               ///< v_s, m/s

    void fields(FieldVisitor& f) {
        f.visit({.name = "point", .unit = "m", .text = "on the plane"}, point);
        f.visit({.name = "normal",
                 .unit = "-",
                 .text = "of the plane, towards the rods; all that presses them on it counts: loads, contacts and walls"},
                normal);
        f.visit({.name = "stiffness", .unit = "N/m", .text = "of the plane per element", .required = true, .at_least = 0},
                stiffness);
        f.visit({.name = "damping", .unit = "N s/m", .text = "of the plane per element", .at_least = 0}, damping);
        f.visit({.name = "tolerance", .unit = "m", .text = "gap up to which an element counts as touching", .at_least = 0},
                tolerance);
        f.visit({.name = "kinetic_forward", .unit = "-", .text = "sliding friction of motion along the tangent", .at_least = 0},
                kinetic_forward);
        f.visit({.name = "kinetic_backward", .unit = "-", .text = "sliding friction of motion against the tangent", .at_least = 0},
                kinetic_backward);
        f.visit({.name = "kinetic_sideways", .unit = "-", .text = "sliding friction across", .at_least = 0}, kinetic_sideways);
        f.visit({.name = "static_forward", .unit = "-", .text = "holds against forces along the tangent", .at_least = 0},
                static_forward);
        f.visit({.name = "static_backward", .unit = "-", .text = "holds against forces against the tangent", .at_least = 0},
                static_backward);
        f.visit({.name = "static_sideways", .unit = "-", .text = "lets roll without slip", .at_least = 0}, static_sideways);
        f.visit({.name = "slip_speed", .unit = "m/s", .text = "v_s: slower is held, above twice this slides", .above = 0},
                slip_speed);
    }

    std::vector<double> share; ///< m_k/(m_k + m_{k+1}), [n]

    void bind_group(const RodGroup& group) {
        if (group.closed()) throw InputError("rods '" + group.name() + "': the load anisotropic_plane does not take rings");
        const double size = norm(normal);
        if (!(size > 0)) throw InputError("load anisotropic_plane: the normal has no direction");
        normal = (1 / size) * normal;
        for (std::size_t k = 0; k + 1 < group.node_mass.size(); ++k)
            share.push_back(mass(group, k) / (mass(group, k) + mass(group, k + 1)));
    }

    template <int W, class Map = Across<W>> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const {
        using P = Pack<W>;
        const bool holds = static_forward > 0 || static_backward > 0 || static_sideways > 0;
        // Every element sees nodes as the stage before has left them for all: its halves are handed on one element late.
        Vec3<P> plane_half{}, static_half{};
        Grip<P> before{};
        for (int k = 0; k < rod.n; ++k) {
            const Grip<P> grip = grip_of(rod, load, k);
            const Vec3<P> sliding = slide(rod, load, k, grip), half = P(0.5) * (grip.force + sliding);
            load[k].force += plane_half + half;
            plane_half = half;
            if (k == rod.n - 1) load[rod.n].force += half;
            if (!holds) continue;
            if (k > 0) {
                // Node k lacks nothing but what this element's neighbour behind holds.
                const Vec3<P> held = P(0.5) * hold(rod, load, k - 1, before);
                load[k - 1].force += static_half + held;
                static_half = held;
            }
            before = grip;
        }
        if (!holds) return;
        const Vec3<P> held = P(0.5) * hold(rod, load, rod.n - 1, before);
        load[rod.n - 1].force += static_half + held;
        load[rod.n].force += held;
    }

private:
    /// How an element lies on the plane.
    template <class P> struct Grip {
        Vec3<P> along, across, force; ///< a, b, the plane's force
        P radius, push;
        P slip_along, slip_across; ///< v_a, v_b
        P rest_along, rest_across; ///< phi
    };

    static double mass(const RodGroup& group, std::size_t i) { return std::max(group.node_mass[i], 1e-300); }

    template <class P> SKEIN_INLINE static Vec3<P> unit(const Vec3<P>& a) { return (P(1.0) / max(norm(a), P(1e-300))) * a; }
    template <class P> SKEIN_INLINE P resting(P speed) const {
        const P over = abs(speed) * P(1 / slip_speed);
        return max(P(0.0), min(P(1.0), P(2.0) - over));
    }
    /// Half of both nodes' loads, all of an end's.
    template <int W> SKEIN_INLINE static Vec3<Pack<W>> element_load(const RodTile<W>& rod, const SlotLoad<W>* load, int k) {
        const Pack<W> first(k == 0 ? 1.0 : 0.5), last(k == rod.n - 1 ? 1.0 : 0.5);
        return fma(first, load[k].force, last * load[k + 1].force);
    }

    template <int W> SKEIN_INLINE Grip<Pack<W>> grip_of(const RodTile<W>& rod, const SlotLoad<W>* load, int k) const {
        using P = Pack<W>;
        const P zero(0.0), half(0.5);
        const Slot<W>&s = rod.slot[k], &next = rod.slot[k + 1];
        const Vec3<P> up = broadcast<W>(normal), edge = next.position - s.position;
        Grip<P> g;
        g.along = unit(edge - dot(edge, up) * up);
        g.across = cross(g.along, up);
        g.radius = sqrt(P(rod.element[k].volume / std::numbers::pi) / norm(edge));

        const double before = share[static_cast<std::size_t>(k)];
        const Vec3<P> v = fma(P(before), s.velocity, P(1 - before) * next.velocity);
        const P gap = dot(up, half * (s.position + next.position) - broadcast<W>(point)) - g.radius;
        const auto touches = gap <= P(tolerance);
        g.push = select(touches, max(zero, -dot(element_load(rod, load, k), up)), zero);
        const P plane = g.push - P(stiffness) * min(zero, gap) - P(damping) * dot(v, up);
        g.force = select(touches, plane, zero) * up;

        const Vec3<P> turning = transpose_times(s.director, cross(s.spin, s.director * (-g.radius * up)));
        g.slip_along = dot(v, g.along);
        g.slip_across = dot(v, g.across) + dot(turning, g.across);
        g.rest_along = resting(g.slip_along);
        g.rest_across = resting(g.slip_across);
        return g;
    }

    /// Sliding friction on the element; its couple goes into the load.
    template <int W>
    SKEIN_INLINE Vec3<Pack<W>> slide(const RodTile<W>& rod, SlotLoad<W>* load, int k, const Grip<Pack<W>>& g) const {
        using P = Pack<W>;
        const P per_slip = g.push / max(sqrt(fma(g.slip_along, g.slip_along, g.slip_across * g.slip_across)), P(1e-300));
        const P coefficient = select(g.slip_along > P(0.0), P(kinetic_forward), P(kinetic_backward));
        const Vec3<P> across = (-((P(1.0) - g.rest_across) * P(kinetic_sideways) * per_slip * g.slip_across)) * g.across;
        turn(rod, load, k, g, across);
        return fma(-((P(1.0) - g.rest_along) * coefficient * per_slip * g.slip_along), g.along, across);
    }

    /// Friction that holds the element; its couple goes into the load.
    template <int W>
    SKEIN_INLINE Vec3<Pack<W>> hold(const RodTile<W>& rod, SlotLoad<W>* load, int k, const Grip<Pack<W>>& g) const {
        using P = Pack<W>;
        const Vec3<P> all = element_load(rod, load, k), couple = transpose_times(rod.slot[k].director, load[k].couple);
        const auto clamped = [](P x, P low, P high) { return min(max(x, -low), high); };
        const P along =
            clamped(dot(all, g.along), g.rest_along * P(static_backward) * g.push, g.rest_along * P(static_forward) * g.push);
        const P no_slip = (P(2.0) * dot(couple, g.along) - g.radius * dot(all, g.across)) / (P(3.0) * g.radius);
        const P most = g.rest_across * P(static_sideways) * g.push;
        const Vec3<P> across = clamped(no_slip, most, most) * g.across;
        turn(rod, load, k, g, across);
        return across - along * g.along;
    }

    template <int W> SKEIN_INLINE static void turn(const RodTile<W>& rod, SlotLoad<W>* load, int k, const Grip<Pack<W>>& g,
                                                   const Vec3<Pack<W>>& across) {
        // arm x F with arm = -r N, and N x b = a: -r F_b a
        load[k].couple += rod.slot[k].director * (-(g.radius * dot(across, g.across)) * g.along);
    }
};

} // namespace skein
