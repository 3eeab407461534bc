// Tapered rods bend as their sections at the nodes: the tip under a small load against the integral of M (L - s)/(E I).
#include "loads/end_force.hpp"
#include "support/rods_for_tests.hpp"
#include "support/statics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace skein {
namespace {

constexpr double radius = 0.02, length = 1;

/// Over the scale's linear fall to `taper`: F/E times integrals of (L - s)^2/I and, for shear, of 3/(alpha_c A); Simpson's rule.
double deflection(const RodSpec& spec, double taper, double force) {
    constexpr int steps = 40000;
    const auto density = [&](double s) {
        const double f = 1 + (taper - 1) * s, area = std::numbers::pi * f * f * radius * radius;
        return (1 - s) * (1 - s) / (0.25 * area * f * f * radius * radius) + 3 / (spec.material.shear_factor * area);
    };
    double sum = density(0) + density(1);
    for (int i = 1; i < steps; ++i) sum += (i % 2 ? 4 : 2) * density(static_cast<double>(i) / steps);
    return force / spec.material.youngs_modulus * sum / (3 * steps);
}

enum class Given { taper, profile, turned_round };

/// `turned_round`: clamped at the end, the thick one.
double error_of_tip(Given given, double taper, long n) {
    RodSpec spec = test::simple_rod(n);
    spec.section = {.radius = radius, .taper = taper};
    spec.start = EndKind::clamped;
    if (given == Given::turned_round) {
        spec.section = {.radius = taper * radius, .taper = 1 / taper};
        std::swap(spec.start, spec.end);
    }
    if (given == Given::profile) {
        spec.section.taper = 1;
        for (long k = 0; k < n; ++k)
            spec.section.profile.push_back(1 + (taper - 1) * (static_cast<double>(k) + 0.5) / static_cast<double>(n));
    }
    const double force = 1e-12;
    const RodGroup group(spec, 0, 0, "");
    test::Statics rod(group);
    rod.loads = {given == Given::turned_round ? EndForce{.start = {force, 0, 0}} : EndForce{.end = {force, 0, 0}}};
    rod.rest();
    const auto& tip = given == Given::turned_round ? rod.state.front() : rod.state.back();
    return lane(tip.position, 0).x / deflection(spec, taper, force) - 1;
}

TEST(Taper, BendsAsTheIntegralSays) {
    for (const Given given : {Given::taper, Given::profile, Given::turned_round}) {
        const double to_a_fifth = error_of_tip(given, 0.2, 20), to_a_twentieth = error_of_tip(given, 0.05, 20);
        const double order = std::log2(error_of_tip(given, 0.2, 20) / error_of_tip(given, 0.2, 40));
        std::printf("n = 20: taper to 0.2 %.2e, to 0.05 %.2e, order of the first %.2f\n", to_a_fifth, to_a_twentieth, order);
        EXPECT_LE(std::abs(to_a_fifth), 1e-3);
        EXPECT_GE(order, 1.9);
    }
}

TEST(Taper, OfUniformRodsChangesNoBit) {
    RodSpec spec = test::simple_rod(7);
    const RodGroup group(spec, 0, 0, "");
    for (const VoronoiConstants& v : group.voronoi)
        EXPECT_EQ(v.stiffness.x,
                  (1 / (2 * group.element[0].rest_length)) * (group.element[0].rest_length * group.element[0].bending.x +
                                                              group.element[0].rest_length * group.element[0].bending.x));
    EXPECT_EQ(group.start_wall.stiffness.z, group.element[0].bending.z);
    spec.section.profile.assign(7, 0.7);
    const RodGroup scaled(spec, 0, 0, "");
    EXPECT_EQ(scaled.end_wall.stiffness.x, scaled.element[0].bending.x);
}

/// A wall's section is not made nothing by a step beside it.
TEST(Taper, LeavesAWallStiffBesideAStep) {
    RodSpec spec = test::simple_rod(6);
    spec.start = spec.end = EndKind::clamped;
    spec.section.profile = {1, 10, 10, 10, 1, 10};
    const RodGroup group(spec, 0, 0, "");
    EXPECT_NEAR(group.start_wall.stiffness.x, group.element[0].bending.x / 16, 1e-12 * group.element[0].bending.x);
    EXPECT_NEAR(group.end_wall.stiffness.x, 14.5 * 14.5 * 14.5 * 14.5 * group.element[0].bending.x,
                1e-9 * group.end_wall.stiffness.x);
}

} // namespace
} // namespace skein
