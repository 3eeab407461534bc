// Large rotations in three dimensions, at rest: a dead force F on the end of a clamped rod, E I/L^2 (4, 1.2, 0) on a
// straight one and E I/L^2 (6, 1.8, 0) on an arc of 45 degrees in the y-z plane (r = 0.03 L, G = E/3). The continuum of
// the incompressible law:
//   n = Q F,  m = Q [(x(L) - x) x F]                                                       balance, body axes
//   nu_1,2 = n_1,2/(alpha_c G A),  kappa - kappa0 = e^3 B^-1 m,  E A (1 - 1/e) = n_3 + (3/2) e^2 m.B^-1 m
//   x' = Q^T nu,  Q' = -[kappa] Q
// of the linear law, with kappa - kappa0 = B^-1 m and E A (e - 1) = n_3; and of the published law, whose e is |nu|:
//   nu_1,2 = e n_1,2/(alpha_c G A),  E A (nu_3 - 1) = e n_3,  kappa - kappa0 = e^3 B^-1 m
// solved by shooting for x(L).
#pragma once

#include "loads/end_force.hpp"
#include "support/relaxation.hpp"

#include <numbers>

namespace skein::test::large_rotation {

constexpr double radius = 0.03, area = std::numbers::pi * radius * radius; // L = rho = E = 1
constexpr double bending = 0.25 * area * radius * radius, twisting = 2 * bending / 3, shearing = 27.0 / 28 / 3 * area;

struct TipLoad {
    Vec3d rest_curvature, force; ///< 1/L; EI/L^2
};
constexpr TipLoad straight{{0, 0, 0}, {4, 1.2, 0}}, bend{{-0.25 * std::numbers::pi, 0, 0}, {6, 1.8, 0}};

/// Tip of the rod that bends under `force` with the lever arms of a tip at `end`; fourth-order Runge-Kutta.
inline Vec3d shoot(Law law, const TipLoad& load, const Vec3d& force, const Vec3d& end) {
    struct State {
        Vec3d x;
        Mat3d q;
    };
    const auto rate = [&](const State& s) {
        const Vec3d n = s.q * force, m = s.q * cross(end - s.x, force);
        const Vec3d bent{m.x / bending, m.y / bending, m.z / twisting};
        Vec3d nu{n.x / shearing, n.y / shearing, 1 + n.z / area};
        double e = nu.z;
        for (int i = 0; i < 40 && law == Law::incompressible; ++i)
            nu.z = e = 1 / (1 - (n.z + 1.5 * e * e * dot(m, bent)) / area);
        for (int i = 0; i < 40 && law == Law::elastica; ++i) {
            nu = {e * n.x / shearing, e * n.y / shearing, 1 + e * n.z / area};
            e = norm(nu);
        }
        const Vec3d kappa = load.rest_curvature + (law == Law::linear ? 1 : e * e * e) * bent;
        const auto turned = [&](const Vec3d& column) { return -cross(kappa, column); };
        const Vec3d c1 = turned({s.q.d1.x, s.q.d2.x, s.q.d3.x}), c2 = turned({s.q.d1.y, s.q.d2.y, s.q.d3.y}),
                    c3 = turned({s.q.d1.z, s.q.d2.z, s.q.d3.z});
        return State{transpose_times(s.q, nu), {{c1.x, c2.x, c3.x}, {c1.y, c2.y, c3.y}, {c1.z, c2.z, c3.z}}};
    };
    const auto ahead = [](const State& a, double h, const State& r) {
        return State{fma(h, r.x, a.x), {fma(h, r.q.d1, a.q.d1), fma(h, r.q.d2, a.q.d2), fma(h, r.q.d3, a.q.d3)}};
    };
    constexpr int steps = 1000;
    constexpr double h = 1.0 / steps;
    State s{{0, 0, 0}, matrix(no_turn)};
    for (int i = 0; i < steps; ++i) {
        const State k1 = rate(s), k2 = rate(ahead(s, h / 2, k1)), k3 = rate(ahead(s, h / 2, k2)),
                    k4 = rate(ahead(s, h, k3));
        s = ahead(ahead(ahead(ahead(s, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
    }
    return s.x;
}

/// Tip under the whole load, by Newton's method for x(L) = shoot(x(L)), the load in twenty parts.
inline Vec3d tip(Law law, const TipLoad& load) {
    Vec3d end = shoot(law, load, {0, 0, 0}, {0, 0, 0});
    for (int part = 1; part <= 20; ++part) {
        const Vec3d force = (bending * part / 20) * load.force;
        const auto miss = [&](const Vec3d& x) { return shoot(law, load, force, x) - x; };
        for (int iteration = 0; iteration < (part < 20 ? 2 : 6); ++iteration) {
            constexpr double d = 1e-5;
            const Vec3d r = miss(end);
            const auto column = [&](const Vec3d& direction) {
                return (0.5 / d) * (miss(end + d * direction) - miss(end - d * direction));
            };
            const Vec3d a = column({1, 0, 0}), b = column({0, 1, 0}), g = column({0, 0, 1});
            const double determinant = dot(a, cross(b, g));
            end -= (1 / determinant) * Vec3d{dot(r, cross(b, g)), dot(a, cross(r, g)), dot(a, cross(b, r))};
        }
    }
    return end;
}

inline SceneSpec scene(const TipLoad& load, long n) {
    RodSpec rod = clamped_unit_rod(n, radius);
    rod.shape.rest_curvature = load.rest_curvature;
    return coming_to_rest(rod, cantilever_frequency(rod), {{.load = EndForce{.end = bending * load.force}}});
}

} // namespace skein::test::large_rotation
