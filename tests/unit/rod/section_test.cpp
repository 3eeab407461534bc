// Constants of sections: torsion of ellipses, what a scene gives by number, and the limits of the step that follow.
#include "mechanics/present_eigenvalues.hpp"
#include "rod/time_limits.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

RodSpec elliptic(double a, double b) {
    RodSpec spec = test::simple_rod(6);
    spec.section = {.kind = SectionKind::elliptic, .radius = a, .radius_2 = b};
    return spec;
}

TEST(Section, OfAnEllipseTwistsAsStVenantSays) {
    for (const auto& [a, b] : {std::pair{0.02, 0.02}, {0.02, 0.01}, {0.003, 0.03}}) {
        const RodGroup group(elliptic(a, b), 0, 0, "");
        const double shear = 1e6 / 3, exact = shear * pi * a * a * a * b * b * b / (a * a + b * b);
        for (const ElementConstants& c : group.element) {
            EXPECT_NEAR(c.bending.z, exact, 1e-15 * exact * 4);
            const double polar = 1000 * c.rest_length * pi / 4 * a * b * (a * a + b * b);
            EXPECT_NEAR(c.inertia.z, polar, 1e-15 * polar * 4) << "inertia is that of the polar moment";
        }
        for (const VoronoiConstants& c : group.voronoi) EXPECT_NEAR(c.stiffness.z, exact, 1e-15 * exact * 4);
        const RodGroup turned(elliptic(b, a), 0, 0, "");
        EXPECT_NEAR(turned.element[0].bending.z, exact, 1e-15 * exact * 4);
    }
}

TEST(Section, OfARectangle) {
    for (const auto& [a, b] : {std::pair{0.02, 0.02}, {0.02, 0.01}, {0.003, 0.03}}) {
        RodSpec spec = elliptic(a, b);
        spec.section.kind = SectionKind::rectangular;
        const RodGroup group(spec, 0, 0, "");
        const double l = std::max(a, b), s = std::min(a, b);
        double rest = 0; // St Venant's series
        for (int n = 1; n < 60; n += 2) rest += std::tanh(n * pi * l / (2 * s)) / std::pow(n, 5);
        const double torsion = 1e6 / 3 * 16 / 3 * l * s * s * s * (1 - 192 / std::pow(pi, 5) * s / l * rest);
        for (const ElementConstants& c : group.element) {
            EXPECT_NEAR(c.volume, 4 * a * b * c.rest_length, 1e-15);
            EXPECT_NEAR(c.bending.x, 1e6 * 4 * a * b * b * b / 3, 1e-12 * c.bending.x);
            EXPECT_NEAR(c.bending.y, 1e6 * 4 * a * a * a * b / 3, 1e-12 * c.bending.y);
            EXPECT_NEAR(c.bending.z, torsion, 5e-3 * torsion);
            const double polar = 1000 * c.rest_length * 4 * a * b * (a * a + b * b) / 3;
            EXPECT_NEAR(c.inertia.z, polar, 1e-12 * polar);
        }
    }
}

TEST(Section, OfACircleHasTheBitsOfItsPolarMoment) {
    RodSpec spec = elliptic(0.013, 0.013);
    const RodGroup ellipse(spec, 0, 0, "");
    spec.section = {.radius = 0.013};
    const RodGroup circle(spec, 0, 0, "");
    EXPECT_EQ(ellipse.element[0].bending.z, circle.element[0].bending.z);
    const double i1 = 0.25 * pi * 0.013 * 0.013 * 0.013 * 0.013;
    EXPECT_EQ(circle.element[0].bending.z, 1e6 / 3 * (i1 + i1));
}

TEST(Section, TakesConstantsByNumber) {
    RodSpec spec = elliptic(0.02, 0.01);
    spec.section.taper = 0.5;
    const RodGroup plain(spec, 0, 0, "");
    spec.section.torsion_constant = 3e-9;
    spec.section.shear_factors = {0.8, 0.5};
    spec.section.bending_stiffness = {0.02, 0.07};
    const RodGroup given(spec, 0, 0, "");
    for (std::size_t k = 0; k < 6; ++k) {
        const ElementConstants &c = given.element[k], &shape = plain.element[k];
        const double f = 1 - 0.5 * (static_cast<double>(k) + 0.5) / 6, f4 = f * f * f * f, shear = 1e6 / 3,
                     area = pi * 0.02 * 0.01 * f * f;
        EXPECT_NEAR(c.bending.x, 0.02 * f4, 1e-16);
        EXPECT_NEAR(c.bending.y, 0.07 * f4, 1e-16);
        EXPECT_NEAR(c.bending.z, shear * 3e-9 * f4, 1e-17);
        EXPECT_NEAR(c.stiffness.x, 0.8 * shear * area, 1e-12);
        EXPECT_NEAR(c.stiffness.y, 0.5 * shear * area, 1e-12);
        EXPECT_EQ(c.stiffness.z, shape.stiffness.z);
        EXPECT_EQ(norm(c.inertia - shape.inertia), 0);
        EXPECT_EQ(c.volume, shape.volume);
    }
}

double limit_of(const RodGroup& group, std::string_view mode) {
    for (const TimeLimit& limit : time_limits(group))
        if (limit.mode == mode) return limit.dt;
    return 0;
}

// h = 2/sqrt(beta_3), and beta_3 is G I_t over the polar inertia.
TEST(Section, SetsTheLimitOfTwist) {
    const double a = 0.02, b = 0.004;
    RodSpec spec = elliptic(a, b);
    const RodGroup ribbon(spec, 0, 0, "");
    const double torsion = pi * a * a * a * b * b * b / (a * a + b * b), polar = pi / 4 * a * b * (a * a + b * b);
    spec.section.torsion_constant = polar;
    const RodGroup stiff(spec, 0, 0, "");
    const double ratio = limit_of(ribbon, "twist") / limit_of(stiff, "twist");
    EXPECT_NEAR(ratio, std::sqrt(polar / torsion), 1e-12 * ratio);
    // A waveform on a straight uniform rod: 2/h = (2/l) sqrt(G I_t/(rho I_3)).
    const double exact = (1.0 / 6) * std::sqrt(1000 * polar / (1e6 / 3 * torsion));
    EXPECT_NEAR(limit_of(ribbon, "twist"), exact, 1e-12 * exact);
}

// A circular section whose axes differ by numbers is not a round one for whoever watches the step.
TEST(Section, IsWatchedAboutBothAxes) {
    RodSpec spec = test::simple_rod(6);
    spec.section.shear_factors = {1, 0.01};
    for (const bool swapped : {false, true}) {
        if (swapped) std::swap(spec.section.shear_factors[0], spec.section.shear_factors[1]);
        const RodGroup group(spec, 0, 0, "");
        std::vector<Slot<1>> state(7);
        group.start_state(0, state);
        const double watched = 2 / std::sqrt(largest_eigenvalue(tile_of(group, state))[0]),
                     planned = time_limits(group).front().dt;
        EXPECT_NEAR(watched, planned, 1e-9 * planned) << swapped;
    }
}

} // namespace
} // namespace skein
