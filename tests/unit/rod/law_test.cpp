// What the laws mean at finite strain, against closed forms of rods that are strained evenly.             theory.md
// (11a)-(11d)
#include "mechanics/law.hpp"

#include "rod/time_limits.hpp"
#include "support/statics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skein {
namespace {

constexpr double radius = 0.1, modulus = 1e6, area = std::numbers::pi * radius * radius, tension = modulus * area,
                 bending = 0.25 * tension * radius * radius, torsion = 0.5 * tension / 3 * radius * radius; // G = E/3

/// A rod between two clamps that may float: whatever the walls' frames do to it, it has no force on it, and is strained
/// evenly.
RodSpec floating(Law law, const Vec3d& curvature, long n = 4) {
    RodSpec spec = test::simple_rod(n);
    spec.material = {.density = 1000, .youngs_modulus = modulus, .law = law};
    spec.section.radius = radius;
    spec.shape.start_curvature = curvature;
    spec.start = spec.end = EndKind::clamped;
    spec.end_free = "xyz";
    return spec;
}

/// Dilatations at rest; the same in all elements.
double rest_dilatation(const RodSpec& spec) {
    const RodGroup group(spec, 0, 0, "");
    test::Statics rod(group);
    rod.rest();
    double least = HUGE_VAL, most = 0;
    for (std::size_t k = 0; k < group.element.size(); ++k) {
        const Vec3d dx = lane(rod.state[k + 1].position, 0) - lane(rod.state[k].position, 0);
        const double e = (lane(rod.state[k].director, 0) * dx).z / group.element[k].rest_length;
        least = std::min(least, e);
        most = std::max(most, e);
    }
    EXPECT_LT(most - least, 1e-10);
    return most;
}

/// The root of a function that rises, between 0.5 and 4.
template <class F> double root(F&& f) {
    double low = 0.5, high = 4;
    for (int i = 0; i < 100; ++i) (f(0.5 * (low + high)) > 0 ? high : low) = 0.5 * (low + high);
    return 0.5 * (low + high);
}

// (E A/3)(e - 1/e^2) = G J k^2/(2 e^2): e^3 = 1 + 3 G J k^2/(2 E A), the closed form of a neo-Hookean cylinder.
TEST(Laws, LengthenATwistedRod) {
    for (const double twist : {0.5, 3.0, 8.0}) {
        EXPECT_NEAR(rest_dilatation(floating(Law::neo_hookean, {0, 0, twist}, 8)),
                    std::cbrt(1 + 1.5 * torsion * twist * twist / tension), 1e-10);
        EXPECT_NEAR(rest_dilatation(floating(Law::incompressible, {0, 0, twist}, 8)), root([&](double e) {
                        return tension * (e - 1) / e - 1.5 * torsion * twist * twist / (e * e * e * e);
                    }),
                    1e-10);
        EXPECT_NEAR(rest_dilatation(floating(Law::linear, {0, 0, twist}, 8)), 1, 1e-10);
    }
    const auto longer = [](Law law) { return rest_dilatation(floating(law, {0, 0, 0.1})) - 1; };
    EXPECT_NEAR(longer(Law::incompressible), 0.25 * 1e-4, 1e-8) << "(r kappa)^2/4";
    EXPECT_NEAR(longer(Law::neo_hookean) / longer(Law::incompressible), 1.0 / 3, 1e-4);
}

// E A (e - 1/e^2)/3 = E I k^2 (1/e^2 + 8/e^5)/6
TEST(Laws, LengthenABentRod) {
    for (const double curvature : {0.5, 2.0, 5.0}) {
        const double q = bending * curvature * curvature;
        EXPECT_NEAR(rest_dilatation(floating(Law::neo_hookean, {curvature, 0, 0})), root([&](double e) {
                        return tension * (e - 1 / (e * e)) / 3 - q * (1 / (e * e) + 8 / (e * e * e * e * e)) / 6;
                    }),
                    1e-10);
    }
    for (const Law law : {Law::incompressible, Law::neo_hookean})
        EXPECT_NEAR(rest_dilatation(floating(law, {0, 0.1, 0})) - 1, 0.375 * 1e-4, 1e-8) << "3 (r kappa)^2/8";
}

TEST(NeoHookean, IsPulledAlongItsClosedForm) {
    for (const double rest : {1.0, 1.2, 0.8}) {
        RodSpec spec = test::simple_rod(4);
        spec.material = {.density = 1000, .youngs_modulus = modulus, .law = Law::neo_hookean};
        spec.section.radius = radius;
        spec.shape.rest_strain = {0, 0, rest - 1};
        const ElementConstants c = RodGroup(spec, 0, 0, "").element[0];
        // The section at rest has the area A/e0.
        for (const double stretch : {0.6, 1.0, 1.3, 2.5}) {
            const double e = rest * stretch, n = NeoHookeanLaw::stress(c, Vec3d{0, 0, e}).z;
            EXPECT_NEAR(n, tension / rest / 3 * (stretch - 1 / (stretch * stretch)), 1e-12 * tension);
            const double step = 1e-4;
            const auto energy = [&](double at) { return NeoHookeanLaw::stretch_energy(c, Pack<1>(at))[0]; };
            EXPECT_NEAR((energy(e + step) - energy(e - step)) / (2 * step), n, 1e-6 * tension);
            EXPECT_NEAR((NeoHookeanLaw::stress(c, Vec3d{0, 0, e + step}).z -
                         NeoHookeanLaw::stress(c, Vec3d{0, 0, e - step}).z) /
                            (2 * step),
                        NeoHookeanLaw::stretch_stiffness(c, e), 1e-6 * tension);
        }
    }
}

/// Of a section whose fibres, at the distance Y at rest, are pulled to e + kappa Y/sqrt(e): the integral of (E/6)(l^2 +
/// 2/l - 3).
double energy_of_fibres(double e, double curvature) {
    constexpr int rings = 200, spokes = 64;
    double sum = 0;
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < spokes; ++j) {
            const double r = radius * (i + 0.5) / rings, y = r * std::sin(2 * std::numbers::pi * (j + 0.5) / spokes);
            const double l = e + curvature * y / std::sqrt(e);
            sum += modulus / 6 * (l * l + 2 / l - 3) * r;
        }
    return sum * (radius / rings) * (2 * std::numbers::pi / spokes);
}

TEST(NeoHookean, BendsAsItsFibresDo) {
    for (const double e : {0.8, 1.0, 1.5}) {
        const auto excess = [&](double curvature) {
            const CellFactor<double> f = NeoHookeanLaw::bending_factor(1 / e, 1.0);
            return energy_of_fibres(e, curvature) - energy_of_fibres(e, 0) -
                   0.5 * bending * f.bending * curvature * curvature;
        };
        const double size = 0.5 * bending * 4;
        EXPECT_LT(std::abs(excess(2)), 0.1 * size) << e;
        EXPECT_NEAR(excess(2) / excess(1), 16, 3) << e << ": what is left goes with the fourth power";
    }
}

// Held with its directors along it, it may be pulled to three times its length: e_c = (1 - 3 alpha G/E)^(-1/3).
TEST(NeoHookean, KeepsItsDirectorsInTension) {
    RodSpec spec = test::simple_rod();
    spec.material.law = Law::neo_hookean;
    EXPECT_NEAR(tension_limit(RodGroup(spec, 0, 0, "")), std::cbrt(28.0), 1e-12);
    spec.material.shear_factor = 1;
    EXPECT_TRUE(std::isinf(tension_limit(RodGroup(spec, 0, 0, ""))));
    // The limit is where n_3 e has grown to alpha G A e^2.
    spec.material = {.density = 1000, .youngs_modulus = 1e6, .shear_modulus = 2e5, .law = Law::neo_hookean};
    spec.shape.rest_strain = {0, 0, 0.1};
    const RodGroup group(spec, 0, 0, "");
    const double e = tension_limit(group);
    const ElementConstants& c = group.element[0];
    EXPECT_NEAR(NeoHookeanLaw::stress(c, Vec3d{0, 0, e}).z / (c.stiffness.x * e), 1, 1e-12);
}

} // namespace
} // namespace skein
