// A rod that ends in a tip of L/1e4.
#include "loads/gravity.hpp"
#include "stress/stress_support.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

namespace skein {
namespace {

constexpr double length = 1, base = 0.05, tip = 1e-4;

/// Radius falls linearly along the rod, from `base` to `tip`.
RodSpec spike(long n) {
    RodSpec rod = test::simple_rod(n);
    rod.section = {.radius = base, .taper = tip / base};
    rod.shape.length = length;
    rod.start = EndKind::clamped;
    rod.placement = {.tangent = {1, 0, 0}, .normal = Vec3d{0, 1, 0}};
    return rod;
}

/// Deflection of the tip under its small weight g: integral of M (L - s)/(E I) + Q/(alpha G A), by Simpson's rule.
double deflection(const RodSpec& rod, double g) {
    constexpr int steps = 20000;
    const double h = length / steps, youngs = rod.material.youngs_modulus,
                 shear = rod.material.shear_factor * youngs / 3;
    const auto radius = [](double s) { return base + (tip - base) * s / length; };
    // Q and M by the cone's closed forms: rho g pi (r^2 and its moment) integrated from s to L.
    const double slope = (tip - base) / length, weight = rod.material.density * g * std::numbers::pi;
    const auto force = [&](double s) { return weight * (std::pow(tip, 3) - std::pow(radius(s), 3)) / (3 * slope); };
    const auto moment = [&](double s) { // integral of r(u)^2 (u - s) du, u = s + (r - r_s)/slope
        const double rs = radius(s);
        return weight / (slope * slope) *
               ((std::pow(tip, 4) - std::pow(rs, 4)) / 4 - rs * (std::pow(tip, 3) - std::pow(rs, 3)) / 3);
    };
    const auto density = [&](double s) {
        const double r = radius(s), area = std::numbers::pi * r * r;
        return moment(s) * (length - s) / (youngs * area * r * r / 4) + force(s) / (shear * area);
    };
    double sum = density(0) + density(length);
    for (int i = 1; i < steps; ++i) sum += (i % 2 ? 4 : 2) * density(i * h);
    return sum * h / 3;
}

TEST(Taper, WeightBendsASpikeAsTheBeamSays) {
    constexpr double g = 1e-3;
    double error[4];
    const double exact = deflection(spike(10), g);
    for (int i = 0; i < 4; ++i) {
        SceneSpec scene;
        scene.rods = {spike(10L << i)};
        scene.loads = {{.load = Gravity{.acceleration = {0, 0, -g}}}};
        scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 10}}}; // first mode: 7 rad/s
        scene.time = {.duration = 3};
        test::Stage stage(scene, 1);
        test::advance_checked(stage, stage.plan.steps);
        const auto state = stage.state(0);
        error[i] = std::abs(-lane(state.back().position, 0).z / exact - 1);
    }
    std::printf(
        "spike under its weight: tip %.3e L, error at n = 10, 20, 40, 80: %.2e %.2e %.2e %.2e, orders %.2f %.2f %.2f\n",
        exact / length, error[0], error[1], error[2], error[3], std::log2(error[0] / error[1]),
        std::log2(error[1] / error[2]), std::log2(error[2] / error[3]));
    EXPECT_LE(error[0], 8e-3);
    EXPECT_LE(error[1], 3e-3);
    EXPECT_LE(error[3], 1e-3); // it changes sign between n = 10 and 20: no clean order
}

/// The last element itself as thin as L/1e4.
TEST(Taper, NeedleIsStableAtTheAutomaticStep) {
    constexpr long n = 20;
    SceneSpec scene;
    RodSpec rod = spike(n);
    rod.section.taper = 1;
    for (long k = 0; k < n; ++k) rod.section.profile.push_back(1 + (tip / base - 1) * static_cast<double>(k) / (n - 1));
    scene.rods = {rod};
    scene.time = {.duration = 1};
    test::Stage stage(scene, 1);
    EXPECT_NEAR(stage.groups[0].element.back().radius, tip, 1e-12);
    auto state = test::shaken_state(stage.groups[0], 0, 0, 0);
    const Vec3d axis{0.2, 0.4, 0.1};
    for (std::size_t k = 0; k < state.size(); ++k) // set swinging as a whole
        set_lane(state[k].velocity, 0, cross(axis, lane(state[k].position, 0)));
    stage.rods->import_rod(0, state);
    const std::int64_t steps = test::long_runs() ? 10000000 : 1000000;
    const test::EnergyRecord w = test::worst(test::watch_energy(stage, steps));
    std::printf("needle, %.0e steps of %.2e s: energy drift %.1e, last quarter minus first %.1e, strain %.1f %%\n",
                static_cast<double>(steps), stage.plan.dt, w.drift, w.trend, 100 * w.strain);
    EXPECT_LE(w.drift, 1e-3);
    EXPECT_LE(std::abs(w.trend), 1e-4);
}

} // namespace
} // namespace skein
