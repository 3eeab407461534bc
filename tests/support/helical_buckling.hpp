// Helical buckling: a long rod, both ends clamped, is stretched a little, twisted by 27 turns and then brought together
// by 3 % of its length. It buckles into one localised helix. Far ends and an inextensible rod give (van der Heijden,
// Thompson 2000, Nonlinear Dynamics 21, 71; van der Heijden et al. 2003, Int. J. Solids Struct. 40, 2175; the case of
// Gazzola et al. 2018, section 3.4)
//
//   cos theta = 1 - (1 - cos theta_max) sech^2(a (s - L/2)),   1 - cos theta_max = 2 (1 - m^2),   a = sqrt((1 - m^2)
//   T/B) envelope phi = (cos theta - cos theta_max)/(1 - cos theta_max) = tanh^2(a (s - L/2)),       m = M/(2 sqrt(B
//   T)) end shortening D/L = 4 sqrt((1 - m^2)/y),  end rotation R = x B/C + 4 acos(m),   x = M L/B,  y = T L^2/B
//
// theta: angle of the tangent to the axis; M, T: moment and tension at the ends. The ends stand where the inextensible
// rod's would, plus what tension and shear add, and what twist adds in an incompressible rod, (3/2) M^2/(C E A) per
// length: 0.6 %, nine times what the tension does. Bending adds 4e-5 and is left out.
#pragma once

#include "support/relaxation.hpp"

#include <numbers>

namespace skein::test::helical_buckling {

constexpr double length = 1, radius = 1e-3, turns = 27, slack = 0.03;
constexpr double twist_over_bend = 0.789 / 1.345; ///< C/B as published

struct Localised {
    double moment, tension; ///< x, y
    double rate, depth;     ///< a, 1/m; 1 - cos theta_max
    double cosine(double s) const {
        const double sech = 1 / std::cosh(rate * (s - length / 2));
        return 1 - depth * sech * sech;
    }
};

/// By bisection in m: D gives y, R gives what is left.
inline Localised localised() {
    const auto tension = [](double m) { return 16 * (1 - m * m) / (slack * slack); };
    double low = 0, high = 1;
    for (int i = 0; i < 200; ++i) {
        const double m = 0.5 * (low + high), turn = 2 * m * std::sqrt(tension(m)) / twist_over_bend + 4 * std::acos(m);
        // of the two solutions the one of small loops: R falls as m rises towards 1
        (m < std::numbers::sqrt2 / 2 || turn > 2 * std::numbers::pi * turns ? low : high) = m;
    }
    const double y = tension(low);
    return {2 * low * std::sqrt(y), y, std::sqrt((1 - low * low) * y) / length, 2 * (1 - low * low)};
}

/// `waits`: how long it takes, in 1/omega: half of it to stretch and twist, all of it to approach, three quarters to
/// settle. Finer rods buckle later, and need longer.
inline SceneSpec scene(Law law, long n, double waits) {
    const Localised exact = localised();
    SceneSpec scene;
    RodSpec rod;
    rod.name = "rod";
    rod.material = {.density = 1000, .youngs_modulus = 1e6, .shear_modulus = 0.5e6 * twist_over_bend, .law = law};
    rod.section = {.radius = radius};
    rod.shape = {.length = length, .elements = n};
    rod.start = rod.end = EndKind::clamped;
    const double tension_strain = exact.tension * radius * radius / (4 * length * length); // T/EA
    const double shear_strain = tension_strain / (0.5 * twist_over_bend * rod.material.shear_factor);
    double across = 0; // integral of sin^2 theta, midpoint rule
    for (int i = 0; i < 4000; ++i) across += (1 - std::pow(exact.cosine((i + 0.5) / 4000 * length), 2)) * length / 4000;
    const double twist_strain =
        law == Law::incompressible ? 1.5 * std::pow(exact.moment * radius / (2 * length), 2) / twist_over_bend : 0;
    const double approach = slack * length - tension_strain * (length - across) - shear_strain * across -
                            twist_strain * (1 - slack) * length;
    const double stretch = (1.5 * tension_strain + twist_strain) * length;
    // lowest frequency of the string that the tension makes of the rod
    const double omega =
        std::numbers::pi / length * std::sqrt(tension_strain * rod.material.youngs_modulus / rod.material.density);
    const double wait = waits / omega;
    const Vec3d half{0, 0, std::numbers::pi * turns};
    const std::vector<double> times{0, wait / 4, wait / 2, 1.5 * wait};
    // Both ends do the same, or drag would carry the loop away from the middle.
    const auto apart = [&](double by) { return Vec3d{0, 0, by / 2}; };
    rod.end_motion = {.times = times,
                      .translation = {{0, 0, 0}, apart(stretch), apart(stretch), apart(-approach)},
                      .rotation = {{0, 0, 0}, {0, 0, 0}, half, half},
                      .smooth = true};
    rod.start_motion = rod.end_motion;
    for (Vec3d& u : rod.start_motion.translation) u = -u;
    for (Vec3d& r : rod.start_motion.rotation) r = -r;
    scene.rods = {rod};
    scene.time = {.duration = 2.25 * wait};
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 4 * omega}}};
    return scene;
}

/// Slowest frequency, rad/s.
inline double omega(const Stage& stage) { return stage.scene.damping[0].damping.rate / 4; }

/// To the end of the scene. The straight rod needs a push: sideways in the middle, when it has its twist.
inline void buckle(Stage& stage, Cost& cost) {
    advance(stage, stage.plan.steps * 2 / 9, cost);
    std::vector<Slot<1>> state(static_cast<std::size_t>(stage.groups[0].slots()));
    stage.rods->export_rod(0, state);
    const auto n = static_cast<double>(state.size() - 1);
    for (std::size_t i = 0; i < state.size(); ++i) {
        const double s = (static_cast<double>(i) / n - 0.5) * 10;
        set_lane(state[i].velocity, 0,
                 lane(state[i].velocity, 0) + Vec3d{1e-3 * omega(stage) * length * std::exp(-s * s), 0, 0});
    }
    stage.rods->import_rod(0, state);
    advance(stage, stage.plan.steps, cost);
}

} // namespace skein::test::helical_buckling
