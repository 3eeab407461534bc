// Plane on which rods lie and slide, with different friction forwards, backwards and sideways: snakes. theory.md
// (60)-(62) Per element, N the plane's normal, a = unit(t - (t.N) N), b = a x N, arm -r N; touching where the gap g = d
// - r is at most `tolerance`:
//   F = sum of nodal loads so far, half from each node (whole from end nodes)
//   push   P = max(0, -F.N);  plane force (P - k min(0, g) - c v.N) N;  friction goes by P alone
//   slip   v_a = v.a,  v_b = v.b - r w.(Q a), as N x b = a;  phi(s) = 1 for |s| <= v_s, |2 - |s|/v_s| up to 2 v_s, 0
//          above
//   slides, u = unit(v_a a + v_b b):
//          along -(1 - phi_a) mu_k(sign v_a) P (u.a) a;  sideways -(1 - phi_b) mu_k,side P (u.b) b
//   holds, F with sliding friction in it, c the couple so far:
//          along -clamp(F.a, -phi_a mu_s,back P, phi_a mu_s,forward P) a
//          sideways clamp((2 c.(Q a)/r - F.b)/3, +- phi_b mu_s,side P) b
//   couple of a force f b on its arm: -r f Q a
// Loads already there, internal and external, are read, so it acts after contacts and walls. The velocity is that
// before the kick. Source: Gazzola et al. 2018 (R. Soc. Open Sci. 5, 171628), as PyElastica has it. Cost: 230 flop per
// element, with four square roots and two divisions.
#pragma once

#include "skein/core/error.hpp"
#include "skein/core/fields.hpp"
#include "skein/core/index.hpp"
#include "skein/loads/load.hpp"
#include "skein/rod/rod_spec.hpp"
#include "skein/tiles/mapping.hpp"

#include <algorithm>
#include <numbers>
#include <string>
#include <vector>

namespace skein {

struct PlaneFriction {
    static constexpr std::string_view kind = "anisotropic_plane";
    static constexpr bool acts_last = true;
    static constexpr bool for_rigid_bodies = false, for_rings = false;

    Vec3d point{0, 0, 0};                                                   ///< m
    Vec3d normal{0, 0, 1};                                                  ///< normal, pointing to the rods
    double stiffness = 0;                                                   ///< k, N/m
    double damping = 0;                                                     ///< c, N s/m
    double tolerance = automatic;                                           ///< m
    double kinetic_forward = 0, kinetic_backward = 0, kinetic_sideways = 0; ///< mu_k
    double static_forward = 0, static_backward = 0, static_sideways = 0;    ///< mu_s
    double slip_speed = automatic;                                          ///< v_s, m/s

    static constexpr double automatic = -1;        ///< automatic choice, from rods and weight
    static constexpr double touching_share = 0.01; ///< share of the least radius for an automatic tolerance
    static constexpr double held_share = 0x1p-24;  ///< share of the scene's speed for an automatic slip speed
    static constexpr double most_tolerance = 0.05; ///< radii; rods hover at larger tolerances, and the plan warns

    void fields(FieldVisitor& f) {
        f.visit({.name = "point", .unit = "m", .text = "a point on the plane"}, point);
        f.visit({.name = "normal",
                 .unit = "-",
                 .text = "normal of the plane, towards the rods; the normal force of friction includes loads, contacts "
                         "and walls"},
                normal);
        f.visit({.name = "stiffness",
                 .unit = "N/m",
                 .text = "stiffness of the plane per element",
                 .required = true,
                 .at_least = 0},
                stiffness);
        f.visit({.name = "damping", .unit = "N s/m", .text = "damping of the plane per element", .at_least = 0},
                damping);
        f.visit({.name = "tolerance",
                 .unit = "m",
                 .text = "largest gap at which an element touches the plane and is held; or \"auto\": a hundredth of "
                         "the smallest radius",
                 .at_least = 0,
                 .automatic = automatic},
                tolerance);
        const auto coefficient = [&](std::string_view name, std::string_view text, double& value) {
            f.visit({.name = name, .unit = "-", .text = text, .at_least = 0}, value);
        };
        coefficient("kinetic_forward", "sliding friction of motion along the tangent", kinetic_forward);
        coefficient("kinetic_backward", "sliding friction of motion opposite to the tangent", kinetic_backward);
        coefficient("kinetic_sideways", "sliding friction sideways", kinetic_sideways);
        coefficient("static_forward", "static friction against forces along the tangent", static_forward);
        coefficient("static_backward", "static friction against forces opposite to the tangent", static_backward);
        coefficient("static_sideways", "static friction sideways, which makes rods roll without slip", static_sideways);
        f.visit({.name = "slip_speed",
                 .unit = "m/s",
                 .text = "v_s; elements below this speed are held, elements above twice this speed slide; or \"auto\": "
                         "2^-24 sqrt(g r) with the scene's gravity, 2^-24 (r/L) sqrt(E/rho) without",
                 .above = 0,
                 .automatic = automatic},
                slip_speed);
    }
    void check(RodSpecs, Objections& objections) const {
        if (zero(normal)) objections.add("normal", "'normal' has no direction");
    }

    std::string refine(const Shape& was, const Shape& now) {
        const double share = static_cast<double>(was.elements) / static_cast<double>(now.elements);
        stiffness *= share;
        damping *= share;
        return "stiffness and damping per element are shared among more elements";
    }

    static double least_radius(const RodGroup& group) {
        double least = HUGE_VAL;
        for_each_kind(group, [&](const RodGroup& kind, double) {
            for (const ElementConstants& e : kind.element) least = std::min(least, e.radius);
        });
        return least;
    }
    /// Speed scale of rods at their places: that of a fall through a radius, m/s, or without gravity [m/s^2] that of
    /// bending.
    static double speed_of(const RodGroup& group, double gravity) {
        const double radius = least_radius(group);
        if (gravity > 0) return std::sqrt(gravity * radius);
        const RodSpec& spec = group.spec();
        return radius / spec.shape.length * std::sqrt(spec.material.youngs_modulus / spec.material.density);
    }
    /// Sets numbers in place of automatic ones.
    void choose(double radius, double speed) {
        if (tolerance < 0) tolerance = touching_share * radius;
        if (slip_speed < 0) slip_speed = held_share * speed;
    }

    /// Rate of the plane's damping and stiffness of its spring, where all elements touch.
    DragRate largest_rate(const RodGroup& group) const { return largest_over_mass(damping, group); }
    DragRate largest_stiffness(const RodGroup& group) const { return largest_over_mass(stiffness, group); }

    /// Constants of an element.
    template <class N> struct Row {
        N share;                  ///< m_k/(m_k + m_{k+1})
        N radius, inverse_radius; ///< radius at rest of a circle of the same area, m
        N first, last;            ///< shares of its nodes' loads: half, at ends all
    };
    std::vector<Row<double>> rows; ///< [n]

    void bind_group(const RodGroup& group) {
        const double size = norm(normal);
        if (!(size > 0)) throw InputError("load anisotropic_plane: the normal has no direction");
        normal = (1 / size) * normal;
        choose(least_radius(group), speed_of(group, 0));
        rows = rows_of(group);
    }
    static constexpr bool tables_by_lane = true;
    static std::vector<Row<double>> rows_of(const RodGroup& group) {
        std::vector<Row<double>> rows;
        const std::size_t n = to_index(group.elements());
        for (std::size_t k = 0; k < n; ++k) {
            const double r = std::sqrt(group.element[k].volume / (std::numbers::pi * group.element[k].rest_length));
            rows.push_back({mass(group, k) / (mass(group, k) + mass(group, k + 1)), r, 1 / r, k == 0 ? 1.0 : 0.5,
                            k == n - 1 ? 1.0 : 0.5});
        }
        return rows;
    }

    static constexpr bool data_along_only = true;
    template <int W> using TileData = LaneRows<Row<Pack<W>>>;
    template <int W> TileData<W> bind(const RodTile<W>& rod) const { return in_lanes<Row>(rod, rows_of); }

    template <int W, class Map = Across<W>>
    void add(const RodTile<W>& rod, const TileData<W>& lane_rows, SlotLoad<W>* load, const Step&) const {
        using P = Pack<W>;
        const auto row = [&](int k) -> const auto& { return Map::row(rows, lane_rows, k); };
        const bool holds = static_forward > 0 || static_backward > 0 || static_sideways > 0;
        const int n = rod.n;
        // Every element reads nodes as the previous stage has left them for all: its halves are handed on one element
        // late. Halves of the last element go to the next lane before that begins.
        load[n].force = last_node_value<Map>(rod, load[0].force, load[n].force);
        const Vec3<P> last_velocity = last_node_value<Map>(rod, rod.slot[0].velocity, rod.slot[n].velocity);
        const auto push = [&](int k, Grip<P>& grip) __attribute__((always_inline)) {
            const Vec3<P>& next = k + 1 < n ? rod.slot[k + 1].velocity : last_velocity;
            return where_present<Map>(rod, k, P(0.5) * slide<Map>(rod, load, k, row(k), next, grip));
        };
        const auto hold_half = [&](int k, const Grip<P>& grip) __attribute__((always_inline)) {
            return where_present<Map>(rod, k, P(0.5) * hold<Map>(rod, load, k, row(k), grip));
        };
        Grip<P> last, grips[2];
        const Vec3<P> last_half = push(n - 1, last);
        Vec3<P> plane_half = first_node_value<Map>(rod, last_half), static_half = nothing<W>(),
                first_held = nothing<W>();
        // Load of element k, when its second node lacks only holding friction.
        const auto hold_on = [&](int k) __attribute__((always_inline)) {
            const Vec3<P> held = hold_half(k, grips[k % 2]);
            if (k > 0) load[k].force += static_half + held;
            else first_held = held;
            static_half = held;
        };
        for (int k = 0; k < n - 1; ++k) {
            const Vec3<P> half = push(k, grips[k % 2]);
            load[k].force += plane_half + half;
            plane_half = half;
            if (holds && k > 0) hold_on(k - 1);
        }
        load[n - 1].force += plane_half + last_half;
        load[n].force = last_node_value<Map>(rod, load[0].force, load[n].force + last_half);
        if (!holds) return;
        if (n > 1) hold_on(n - 2);
        const Vec3<P> held = hold_half(n - 1, last);
        if (n > 1) load[n - 1].force += static_half + held;
        else first_held = held;
        load[n].force += held;
        load[0].force += first_node_value<Map>(rod, held) + first_held;
    }

private:
    /// Position of an element on the plane.
    template <class P> struct Grip {
        Vec3<P> along, sideways; ///< a, b
        Vec3<P> axis;            ///< Q a: arm of a force along b, times N x b = a
        P radius, inverse_radius, push;
        P rest_along, rest_sideways; ///< phi
    };

    /// Rate bounded from above by the sum along a node's row: half of the value of each of its elements, over its mass.
    static DragRate largest_over_mass(double of_element, const RodGroup& group) {
        const int n = group.elements();
        DragRate largest;
        for (int i = 0; i <= n; ++i) {
            const double elements = i == 0 || i == n ? 1 : 2,
                         value = 0.5 * of_element * elements / mass(group, to_index(i));
            if (!group.holds_node(i) && value > largest.value) largest = {value, std::min(i, n - 1)};
        }
        return largest;
    }
    static double mass(const RodGroup& group, std::size_t i) { return std::max(group.node_mass[i], 1e-300); }

    template <class P> SKEIN_INLINE P resting(P speed) const {
        const P over = abs(speed) * P(1 / slip_speed);
        return max(P(0.0), min(P(1.0), P(2.0) - over));
    }
    template <int W> SKEIN_INLINE static Vec3<Pack<W>> element_load(const SlotLoad<W>* load, int k, const auto& c) {
        return fma(Pack<W>(c.first), load[k].force, Pack<W>(c.last) * load[k + 1].force);
    }

    /// Force of the plane and of sliding friction; the couple of the latter is added to the load. `next`: velocity of
    /// node k + 1.
    template <class Map, int W> SKEIN_INLINE Vec3<Pack<W>> slide(const RodTile<W>& rod, SlotLoad<W>* load, int k,
                                                                 const auto& c, const Vec3<Pack<W>>& next,
                                                                 Grip<Pack<W>>& g) const {
        using P = Pack<W>;
        const P zero(0.0), half(0.5), one(1.0);
        const Slot<W>& s = rod.slot[k];
        const Vec3<P>& end = rod.slot[k + 1].position;
        const Vec3<P> up = broadcast<W>(normal), edge = end - s.position, flat = edge - dot(edge, up) * up;
        // Inverses of a length and of the square root of a dilatation, with one division.
        const P size = max(norm(flat), P(1e-150)), root = sqrt(norm(edge) * P(Map::element(rod, k).inv_rest_length)),
                inverse = one / (size * root);
        g.along = (root * inverse) * flat;
        g.sideways = cross(g.along, up);
        g.axis = s.director * g.along;
        g.radius = P(c.radius) * (size * inverse);
        g.inverse_radius = P(c.inverse_radius) * root;

        const Vec3<P> v = fma(P(c.share), s.velocity, P(1 - c.share) * next);
        const P gap = dot(up, half * (s.position + end) - broadcast<W>(point)) - g.radius;
        const auto touches = gap <= P(tolerance);
        g.push = select(touches, max(zero, -dot(element_load(load, k, c), up)), zero);
        const P plane = g.push - P(stiffness) * min(zero, gap) - P(damping) * dot(v, up);

        const P slip_along = dot(v, g.along), slip_sideways = fnma(g.radius, dot(s.spin, g.axis), dot(v, g.sideways));
        g.rest_along = resting(slip_along);
        g.rest_sideways = resting(slip_sideways);
        const P per_slip = g.push / max(sqrt(fma(slip_along, slip_along, slip_sideways * slip_sideways)),
                                        P(1e-150)); // at 1e-300 a large push would have no quotient
        const P coefficient = select(slip_along > zero, P(kinetic_forward), P(kinetic_backward));
        const P along = -((one - g.rest_along) * coefficient * per_slip * slip_along),
                sideways = -((one - g.rest_sideways) * P(kinetic_sideways) * per_slip * slip_sideways);
        turn<Map>(rod, load, k, g, sideways);
        return fma(select(touches, plane, zero), up, fma(along, g.along, sideways * g.sideways));
    }

    /// Friction that holds the element; its couple is added to the load.
    template <class Map, int W> SKEIN_INLINE Vec3<Pack<W>> hold(const RodTile<W>& rod, SlotLoad<W>* load, int k,
                                                                const auto& c, const Grip<Pack<W>>& g) const {
        using P = Pack<W>;
        const Vec3<P> all = element_load(load, k, c);
        const auto clamped = [](P x, P low, P high) { return min(max(x, -low), high); };
        const P along = clamped(dot(all, g.along), g.rest_along * P(static_backward) * g.push,
                                g.rest_along * P(static_forward) * g.push);
        const P no_slip =
            P(1.0 / 3) * fma(g.inverse_radius + g.inverse_radius, dot(load[k].couple, g.axis), -dot(all, g.sideways));
        const P most = g.rest_sideways * P(static_sideways) * g.push;
        const P sideways = clamped(no_slip, most, most);
        turn<Map>(rod, load, k, g, sideways);
        return fma(-along, g.along, sideways * g.sideways);
    }

    /// Adds the couple of a force along b on the arm -r N.
    template <class Map, int W> SKEIN_INLINE static void turn(const RodTile<W>& rod, SlotLoad<W>* load, int k,
                                                              const Grip<Pack<W>>& g, Pack<W> sideways) {
        load[k].couple += where_present<Map>(rod, k, (-(g.radius * sideways)) * g.axis);
    }
};

} // namespace skein
