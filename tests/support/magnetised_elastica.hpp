// A clamped rod magnetised along its axis, bond number M A B L^2/(EI), at rest in a transverse field: its
// boundary-value problem.
//   inextensible elastica   EI theta'' + M A B sin(pi/2 - theta) = 0,  theta(0) = 0, theta'(L) = 0       (Wang et al.
//   2020) incompressible law      m' = -M A B cos(theta),  theta' = kappa = m e^3/EI,  EA (1 - 1/e) = (3/2) EI
//   kappa^2/e^4,  x' = e sin(theta)
// The laws linear and elastica do not stretch here: the first is their continuum too.
#pragma once

#include "support/relaxation.hpp"

#include <cmath>

namespace skein::test {

constexpr double magnetised_slenderness = 0.01; ///< radius over length
constexpr Vec3d magnetising_field{0.08, 0, 0};  ///< T

/// One metre long, upright.
inline RodSpec magnetised_rod(double bond, long n) {
    constexpr double youngs = 1e6;
    RodSpec rod;
    rod.name = "rod";
    rod.material = {.density = 1e3, .youngs_modulus = youngs};
    rod.section = {.radius = magnetised_slenderness};
    rod.shape = {.length = 1, .elements = n};
    rod.start = EndKind::clamped;
    rod.magnetisation = {.pattern = MagnetisationPattern::uniform,
                         .strength = bond * youngs * magnetised_slenderness * magnetised_slenderness /
                                     (4 * magnetising_field.x)};
    return rod;
}

/// In lengths: along the field and along the rod at rest.
struct MagnetisedTip {
    double x, z;
};

/// Shooting for the base moment, m(L) = 0, with fourth-order Runge-Kutta. Lengths in L, moments in EI/L. `slenderness`
/// is the radius over the length; 0: inextensible.
inline MagnetisedTip magnetised_tip(double bond, double slenderness) {
    constexpr int steps = 4000;
    const double compliance = 1.5 * 0.25 * slenderness * slenderness; // (3/2) EI/(EA L^2)
    struct State {
        double theta, m, x, z;
    };
    const auto rate = [&](const State& s) {
        double e = 1;
        for (int i = 0; i < 30 && compliance > 0; ++i) e = 1 / (1 - compliance * s.m * s.m * e * e);
        return State{s.m * e * e * e, -bond * std::cos(s.theta), e * std::sin(s.theta), e * std::cos(s.theta)};
    };
    const auto end = [&](double base_moment) {
        State s{0, base_moment, 0, 0};
        const double h = 1.0 / steps;
        const auto ahead = [](const State& a, double d, const State& r) {
            return State{a.theta + d * r.theta, a.m + d * r.m, a.x + d * r.x, a.z + d * r.z};
        };
        for (int i = 0; i < steps; ++i) {
            const State k1 = rate(s), k2 = rate(ahead(s, h / 2, k1)), k3 = rate(ahead(s, h / 2, k2)),
                        k4 = rate(ahead(s, h, k3));
            s = ahead(ahead(ahead(ahead(s, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
        }
        return s;
    };
    double low = 0, high = bond + 1; // m(0) <= bond, since cos <= 1
    for (int i = 0; i < 100; ++i) {
        const double middle = 0.5 * (low + high);
        (end(middle).m > 0 ? high : low) = middle;
    }
    const State s = end(0.5 * (low + high));
    return {s.x, s.z};
}

} // namespace skein::test
