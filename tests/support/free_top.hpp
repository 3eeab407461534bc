// Euler's free top, J3 > J1, J2, in closed form: rates by Jacobi's functions (Landau, Lifshitz, Mechanics, section 37),
// and by one quadrature the orientation.
#pragma once

#include "support/rods_for_tests.hpp"

#include <cmath>

namespace skein::test {

/// Elements of this section are the tops: J of an ellipse a/b, thin disc, largest about d3.
inline RodSpec elliptic_rod(double ratio, long n) {
    RodSpec rod = simple_rod(n);
    rod.section = {.kind = SectionKind::elliptic, .radius = 0.04, .radius_2 = 0.04 / ratio};
    return rod;
}

/// sn, cn, dn of u at parameter m by descending Landen steps (Abramowitz and Stegun 16.4).
struct Jacobi {
    double sn, cn, dn;
};
inline Jacobi jacobi(double u, double m) {
    double a[20], c[20];
    a[0] = 1;
    double b = std::sqrt(1 - m);
    c[0] = std::sqrt(m);
    int i = 0;
    for (; std::abs(c[i]) > 1e-16 && i < 18; ++i) {
        a[i + 1] = 0.5 * (a[i] + b);
        c[i + 1] = 0.5 * (a[i] - b);
        b = std::sqrt(a[i] * b);
    }
    double phi = std::ldexp(a[i] * u, i);
    for (; i > 0; --i) phi = 0.5 * (phi + std::asin(c[i] / a[i] * std::sin(phi)));
    return {std::sin(phi), std::cos(phi), std::sqrt(1 - m * std::sin(phi) * std::sin(phi))};
}

/// Rate at time t, rad/s in body axes, begun with (w1, 0, w3). J3 > J2 > J1, or J3 > J1 > J2 with the names of the
/// first two exchanged: `middle` is the intermediate axis. The start must satisfy L^2 > 2 E J_middle: then w3 keeps its
/// sign.
inline Vec3d free_top(const Vec3d& j, double small_rate, double w3, double t) {
    const bool first_small = j.x < j.y;
    const double small = first_small ? j.x : j.y, middle = first_small ? j.y : j.x, large = j.z;
    const double twice_energy = small * small_rate * small_rate + large * w3 * w3;
    const double momentum_squared = small * small * small_rate * small_rate + large * large * w3 * w3;
    // Landau, Lifshitz, Mechanics (37.8)-(37.12) with L^2 > 2 E J_middle.
    const double scale =
        std::sqrt((large - middle) * (momentum_squared - twice_energy * small) / (small * middle * large));
    const double m = (middle - small) * (twice_energy * large - momentum_squared) /
                     ((large - middle) * (momentum_squared - twice_energy * small));
    const Jacobi f = jacobi(scale * t, m);
    const double amplitude = std::sqrt((twice_energy * large - momentum_squared) / (middle * (large - middle)));
    const double s = small_rate * f.cn, z = w3 * f.dn;
    // J_m dw_m/dt = (J_l - J_s) w_l w_s about (s, m, l) = (1, 2, 3), the other sign where the first two are exchanged.
    const double sense = first_small ? 1 : -1, mid = sense * amplitude * f.sn;
    return first_small ? Vec3d{s, mid, z} : Vec3d{mid, s, z};
}

/// Directors at time t of the top that starts as `start`. With p = J w/|L| the momentum's direction in body axes, Q
/// turns
///   R3(psi) R1(theta) R3(phi) from the axes that have it along z,   p = (sin theta sin psi, sin theta cos psi, cos
///   theta)
/// and phi, which no conservation law gives, goes at (w1 p1 + w2 p2)/(p1^2 + p2^2): Simpson's rule.
inline Mat3d free_top_directors(const Vec3d& j, double small_rate, double w3, double t, const Quaterniond& start) {
    const auto momentum = [&](const Vec3d& w) {
        const Vec3d l = scale(j, w);
        return (1 / norm(l)) * l;
    };
    const auto rate = [&](double at) {
        const Vec3d w = free_top(j, small_rate, w3, at), p = momentum(w);
        return (w.x * p.x + w.y * p.y) / (p.x * p.x + p.y * p.y);
    };
    constexpr int intervals = 20000;
    double phi = rate(0) + rate(t);
    for (int i = 1; i < intervals; ++i) phi += (i % 2 ? 4 : 2) * rate(t * i / intervals);
    phi *= t / (3 * intervals);
    const auto directors = [&](double at, double turn) {
        const Vec3d p = momentum(free_top(j, small_rate, w3, at));
        return rotation({0, 0, std::atan2(p.x, p.y)}) * (rotation({std::acos(p.z), 0, 0}) * rotation({0, 0, turn}));
    };
    // Q(t) = D(t) A with one A for all times: A = D(0)^T Q(0).
    const Quaterniond begin = directors(0, 0);
    return matrix(directors(t, phi) * (Quaterniond{begin.w, -begin.v} * start));
}

} // namespace skein::test
