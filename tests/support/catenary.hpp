// A thin stretchable rod hung by both ends, at rest: the elastic catenary by quadrature.
//   T = sqrt(H^2 + V^2),  V = w (s - L/2),  x' = e H/T,  z' = e V/T,   H from x(L) = span
//   E A (e - 1)/e = T; in the linear law E A (e - 1) = T
// Bending is left out of it: it counts as B/(w L^3) = r^2/(4 L^2) E/(rho g L) = 5e-7.
#pragma once

#include "loads/gravity.hpp"
#include "support/relaxation.hpp"

#include <array>
#include <numbers>
#include <vector>

namespace skein::test::catenary {

constexpr double radius = 3e-4, gravity = 0.05, span = 0.8; // L = rho = E = 1
constexpr double area = std::numbers::pi * radius * radius, weight = area * gravity;

/// x, z at the nodes of n elements for the horizontal tension H; Gauss' rule of three points on 4000/n pieces per
/// element.
inline std::vector<std::array<double, 2>> line(Law law, double tension, long n) {
    std::vector<std::array<double, 2>> points{{0, 0}};
    const long pieces = 4000 / n;
    const double h = 1.0 / static_cast<double>(n * pieces);
    double x = 0, z = 0;
    for (long i = 0; i < n * pieces; ++i) {
        for (const auto [node, share] :
             {std::array{-std::sqrt(0.6), 5.0 / 18}, std::array{0.0, 8.0 / 18}, std::array{std::sqrt(0.6), 5.0 / 18}}) {
            const double v = weight * ((static_cast<double>(i) + 0.5 + 0.5 * node) * h - 0.5),
                         t = std::hypot(tension, v);
            const double e = law == Law::linear ? 1 + t / area : 1 / (1 - t / area);
            x += h * share * e * tension / t;
            z += h * share * e * v / t;
        }
        if ((i + 1) % pieces == 0) points.push_back({x, z});
    }
    return points;
}

/// N
inline double horizontal_tension(Law law) {
    double low = 0, high = weight;
    for (int i = 0; i < 100; ++i)
        (line(law, 0.5 * (low + high), 10).back()[0] > span ? high : low) = 0.5 * (low + high);
    return 0.5 * (low + high);
}

/// Turn per element of a polygon of n sides of 1/n whose chord is the span: the arc from which the rod starts.
inline double arc_turn(long n) {
    double low = 1e-6, high = 2 * std::numbers::pi / static_cast<double>(n);
    const auto chord = [&](double turn) {
        return std::sin(0.5 * static_cast<double>(n) * turn) / std::sin(0.5 * turn) / static_cast<double>(n);
    };
    for (int i = 0; i < 100; ++i) (chord(0.5 * (low + high)) < span ? high : low) = 0.5 * (low + high);
    return 0.5 * (low + high);
}

inline SceneSpec scene(long n) {
    const double turn = arc_turn(n), slope = 0.5 * turn * static_cast<double>(n); // of the arc at its start, downwards
    RodSpec rod;
    rod.name = "chain";
    rod.material = {.density = 1, .youngs_modulus = 1};
    rod.section = {.radius = radius};
    rod.shape = {.length = 1, .elements = n, .start_curvature = Vec3d{0, turn * static_cast<double>(n), 0}};
    rod.placement = {.tangent = {std::cos(slope), 0, -std::sin(slope)},
                     .normal = Vec3d{std::sin(slope), 0, std::cos(slope)}};
    rod.start = rod.end = EndKind::pinned;
    const double omega = 2.5 * std::sqrt(gravity); // below the first sway, 3.6 sqrt(g/L)
    return coming_to_rest(rod, omega, {{.load = Gravity{.acceleration = {0, 0, -gravity}}}});
}

} // namespace skein::test::catenary
