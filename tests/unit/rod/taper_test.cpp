// Tapered rods against the beam whose radius falls linearly: tips under small loads, frequencies, masses, and the
// step's limit.
#include "rod/taper.hpp"

#include "loads/end_force.hpp"
#include "loads/gravity.hpp"
#include "rod/time_limits.hpp"
#include "support/rods_for_tests.hpp"
#include "support/statics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>

namespace skein {
namespace {

constexpr double radius = 0.02, pi = std::numbers::pi;

/// A cone of length 1, clamped at its thick end: w' = theta + V/(alpha_c G A), theta' = M/(E I), M' = -V - rho I W^2
/// theta, V' = -rho A W^2 w.
struct Cone {
    double taper;
    Material material = test::simple_rod().material;

    double scale(double s) const { return 1 + (taper - 1) * s; }
    double area(double s) const { return pi * radius * radius * scale(s) * scale(s); }
    double bent(double s) const { return 4 / (material.youngs_modulus * area(s) * std::pow(radius * scale(s), 2)); }
    double sheared(double s) const { return 3 / (material.youngs_modulus * material.shear_factor * area(s)); }

    /// Simpson's rule in the logarithm of the radius, which a thin tip needs.
    template <class F> double integral(F&& f) const {
        constexpr int steps = 20000;
        double sum = 0;
        for (int i = 0; i <= steps; ++i) {
            const double r = std::pow(taper, static_cast<double>(i) / steps), s = (1 - r) / (1 - taper);
            sum += (i == 0 || i == steps ? 1 : i % 2 ? 4 : 2) * f(s) * r;
        }
        return sum / (3 * steps) * -std::log(taper) / (1 - taper);
    }
    double under_force(double force) const {
        return integral([&](double s) { return force * ((1 - s) * (1 - s) * bent(s) + sheared(s)); });
    }
    double under_weight(double g) const {
        const double t = taper, c = 1 - t, w = material.density * g * pi * radius * radius;
        return integral([&](double s) {
            const double x = 1 - s, force = w * (t * t * x + t * c * x * x + c * c * x * x * x / 3),
                         moment = w * x * x * (t * t / 2 + t * c * x / 3 + c * c * x * x / 12);
            return moment * x * bent(s) + force * sheared(s);
        });
    }
    /// 0 at a frequency: what (M, V) at the clamp make of (M, V) at the tip; fourth-order Runge-Kutta in ln r.
    double determinant(double frequency) const {
        constexpr int steps = 2000;
        const double w2 = frequency * frequency, h = std::log(taper) / steps;
        using State = std::array<double, 4>;
        const auto rate = [&](double log_scale, const State& y) {
            const double r = std::exp(log_scale), s = (1 - r) / (1 - taper), a = area(s) * material.density;
            const double inertia = 0.25 * a * std::pow(radius * r, 2), ds = -r / (1 - taper);
            return State{ds * (y[1] + y[3] * sheared(s)), ds * y[2] * bent(s), ds * (-y[3] - inertia * w2 * y[1]),
                         -ds * a * w2 * y[0]};
        };
        const auto ahead = [](const State& y, double d, const State& r) {
            return State{y[0] + d * r[0], y[1] + d * r[1], y[2] + d * r[2], y[3] + d * r[3]};
        };
        const auto shoot = [&](State y) {
            for (int i = 0; i < steps; ++i) {
                const double at = i * h;
                const State a = rate(at, y), b = rate(at + h / 2, ahead(y, h / 2, a)),
                            c = rate(at + h / 2, ahead(y, h / 2, b)), d = rate(at + h, ahead(y, h, c));
                y = ahead(ahead(ahead(ahead(y, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
            }
            return y;
        };
        const State by_moment = shoot({0, 0, 1, 0}), by_force = shoot({0, 0, 0, 1});
        return by_moment[2] * by_force[3] - by_moment[3] * by_force[2];
    }
    std::array<double, 3> frequencies() const {
        std::array<double, 3> root{};
        const double step = 0.2 * radius * std::sqrt(material.youngs_modulus / material.density);
        double low = step;
        for (std::size_t found = 0; found < root.size(); low += step) {
            if (determinant(low) * determinant(low + step) > 0) continue;
            double a = low, b = low + step;
            for (int i = 0; i < 40; ++i) {
                const double middle = 0.5 * (a + b);
                (determinant(a) * determinant(middle) <= 0 ? b : a) = middle;
            }
            root[found++] = 0.5 * (a + b);
        }
        return root;
    }
};

enum class Given { taper, profile, turned_round };

/// `turned_round`: clamped at the end, the thick one.
RodSpec cone(Given given, double taper, long n) {
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
    return spec;
}

double tip(const RodGroup& group, Load load) {
    test::Statics rod(group);
    rod.loads = {std::move(load)};
    rod.rest();
    const auto& end = group.spec().start == EndKind::free ? rod.state.front() : rod.state.back();
    return lane(end.position, 0).x;
}
double error_under_force(Given given, double taper, long n) {
    const double force = 1e-6 * std::pow(taper * radius, 3); // small for the thinnest tip
    const RodGroup group(cone(given, taper, n), 0, 0, "");
    const Load load = given == Given::turned_round ? EndForce{.start = {force, 0, 0}} : EndForce{.end = {force, 0, 0}};
    return tip(group, load) / Cone{taper}.under_force(force) - 1;
}
double error_under_weight(double taper, long n) {
    constexpr double g = 1e-7;
    const RodGroup group(cone(Given::taper, taper, n), 0, 0, "");
    return tip(group, Gravity{.acceleration = {g, 0, 0}}) / Cone{taper}.under_weight(g) - 1;
}

TEST(Taper, BendsUnderAForceAsTheIntegralSays) {
    for (const Given given : {Given::taper, Given::profile, Given::turned_round})
        for (const double taper : {0.5, 0.2, 0.1, 0.05, 0.02}) {
            const double n10 = error_under_force(given, taper, 10), n20 = error_under_force(given, taper, 20);
            std::printf("taper to %.2f, force on the tip: n = 10, 20: %+.1e %+.1e\n", taper, n10, n20);
            if (taper < 0.05) { // of which the last element falls to less than a third
                EXPECT_LE(std::abs(n10), 0.3);
                EXPECT_LE(std::abs(n20), 0.05);
                continue;
            }
            EXPECT_LE(std::abs(n10), 1e-3) << taper;
            EXPECT_LE(std::abs(n20), 5e-4) << taper;
        }
    EXPECT_GE(std::log2(error_under_force(Given::taper, 0.05, 20) / error_under_force(Given::taper, 0.05, 40)), 1.7);
}

TEST(Taper, BendsUnderItsWeightAsTheIntegralSays) {
    for (const auto& [taper, bar10, bar20] :
         {std::array{0.5, 4e-3, 1e-3}, std::array{0.2, 6e-3, 8e-4}, std::array{0.1, 1.5e-2, 4e-3},
          std::array{0.05, 2e-2, 6e-3}, std::array{0.02, 1e-2, 6e-3}}) {
        const double n10 = error_under_weight(taper, 10), n20 = error_under_weight(taper, 20);
        std::printf("taper to %.2f, weight: n = 10, 20: %+.1e %+.1e\n", taper, n10, n20);
        EXPECT_LE(std::abs(n10), bar10) << taper;
        EXPECT_LE(std::abs(n20), bar20) << taper;
    }
}

TEST(Taper, VibratesAsTheBeam) {
    // At n = 20; with nodes that had halves of their elements' masses 2.5e-3, 4.5e-3 and 6.5e-3 for mode 0.
    for (const auto& [taper, bar] :
         {std::pair{0.5, std::array{1.8e-3, 1e-2, 2.3e-2}}, std::pair{0.2, std::array{2e-3, 1.1e-2, 2.6e-2}},
          std::pair{0.1, std::array{1.5e-3, 1e-2, 2.6e-2}}, std::pair{0.05, std::array{1.5e-3, 9e-3, 3e-2}},
          std::pair{0.02, std::array{1e-3, 7e-3, 4e-2}}}) {
        const auto exact = Cone{taper}.frequencies();
        const RodGroup group(cone(Given::taper, taper, 20), 0, 0, "");
        for (std::size_t mode = 0; mode < 3; ++mode) {
            const auto across = [](bool turns, int axis) { return axis == (turns ? 1 : 0); };
            const double error = test::Statics(group).frequency_near(exact[mode], across) / exact[mode] - 1;
            std::printf("taper to %.2f, frequency %zu: %+.2e\n", taper, mode, error);
            EXPECT_LE(std::abs(error), bar[mode]) << taper << " " << mode;
        }
    }
}

TEST(Taper, GivesNodesTheCentreOfMassOfEveryElement) {
    for (const double after : {1.0, 1.001, 0.5, 0.1, 3.0}) {
        double mass = 0, first = 0;
        constexpr int steps = 1000;
        for (int i = 0; i < steps; ++i) {
            const double t = (i + 0.5) / steps, f = 1 + (after - 1) * t;
            mass += f * f / steps;
            first += f * f * t / steps;
        }
        EXPECT_NEAR(mass_share_before({1, 1}, {after, after}), 1 - first / mass, 1e-6) << after;
    }
    for (const bool closed : {false, true}) {
        RodSpec spec = test::simple_rod(6);
        spec.section.profile = {1, 0.2, 0.5, 3, 0.7, 1};
        spec.shape.closed = closed;
        const RodGroup group(spec, 0, 0, "");
        double mass = 0, volume = 0;
        for (const double m : group.node_mass) mass += m;
        for (const ElementConstants& c : group.element) volume += c.volume;
        EXPECT_NEAR(mass, 1000 * volume, 1e-12 * mass);
    }
}

// x^2 over the compliance of any sections that vary towards a free end: what is left is the trapezoid sum's at the
// wall, g'/12.
TEST(Taper, HasCellsThatAreExactForParabolas) {
    constexpr std::size_t n = 8;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-0.2, 0.2);
    for (int trial = 0; trial < 20; ++trial) {
        SectionScales scales{std::vector<double>(n, 1.0), std::vector<double>(n + 1, 1.0)};
        for (std::size_t i = 0; i < 5; ++i) scales.node[i] = std::exp(any(random));
        for (std::size_t k = 0; k < n; ++k) scales.element[k] = 0.5 * (scales.node[k] + scales.node[k + 1]);
        const auto cell = cell_scales(scales, EndKind::free, EndKind::clamped);
        double sum = 0.5 * n * n, exact = 0;
        for (std::size_t i = 1; i < n; ++i) sum += static_cast<double>(i * i) / std::pow(cell[i], 4);
        constexpr int steps = 2000;
        for (std::size_t k = 0; k < n; ++k)
            for (int i = 0; i < steps; ++i) {
                const double t = (i + 0.5) / steps, x = static_cast<double>(k) + t;
                exact += x * x / std::pow(scales.node[k] + t * (scales.node[k + 1] - scales.node[k]), 4) / steps;
            }
        EXPECT_NEAR(sum - exact, 2.0 * n / 12, 1e-5) << trial;
    }
}

TEST(Taper, HasStiffCellsWhateverTheProfile) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(-3, 3);
    for (const std::size_t n : {2U, 3U, 4U, 5U, 20U})
        for (int trial = 0; trial < 200; ++trial) {
            SectionScales scales{std::vector<double>(n), std::vector<double>(n + 1)};
            for (std::vector<double>* all : {&scales.element, &scales.node})
                for (double& f : *all) f = std::exp(any(random));
            const double least = *std::min_element(scales.element.begin(), scales.element.end());
            for (const EndKind end : {EndKind::free, EndKind::pinned, EndKind::clamped, EndKind::clamped_frozen})
                for (const double f : cell_scales(scales, end, EndKind::free))
                    EXPECT_TRUE(f > 0.5 * std::min(least, *std::min_element(scales.node.begin(), scales.node.end())));
        }
}

TEST(Taper, OfUniformRodsChangesNoBit) {
    RodSpec spec = test::simple_rod(7);
    const RodGroup group(spec, 0, 0, "");
    for (const VoronoiConstants& v : group.voronoi)
        EXPECT_EQ(v.stiffness.x, (1 / (2 * group.element[0].rest_length)) *
                                     (group.element[0].rest_length * group.element[0].bending.x +
                                      group.element[0].rest_length * group.element[0].bending.x));
    EXPECT_EQ(group.start_wall.stiffness.z, group.element[0].bending.z);
    spec.section.profile.assign(7, 0.7);
    const RodGroup scaled(spec, 0, 0, "");
    EXPECT_EQ(scaled.end_wall.stiffness.x, scaled.element[0].bending.x);
    EXPECT_EQ(scaled.nodal_density, group.nodal_density);
    EXPECT_EQ(scaled.node_mass[1], 2 * scaled.node_mass[0]);
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

TEST(Taper, KeepsTheStepsLimitABoundThatIsNear) {
    for (const double taper : {0.5, 0.05, 0.01})
        for (const double aspect : {4.0, 60.0}) {
            RodSpec spec = cone(Given::taper, taper, 9);
            spec.section.radius = 0.5 / aspect;
            const RodGroup group(spec, 0, 0, "");
            const TimeLimit least = time_limits(group).front();
            double most = 0;
            for (const int mode : {0, 1, 2})
                most = std::max(most, test::Statics(group).largest_frequency([&](bool turns, int axis) {
                    return mode == 0 ? axis == (turns ? 1 : 0) : axis == 2 && turns == (mode == 2);
                }));
            std::printf("taper to %.2f, r = L/%.0f: limit of %s, %.4f of the true one\n", taper, 2 * aspect,
                        std::string(least.mode).c_str(), 0.5 * least.dt * most);
            EXPECT_LT(0.5 * least.dt * most, 1 + 1e-6);
            EXPECT_GT(0.5 * least.dt * most, 0.85);
        }
}

} // namespace
} // namespace skein
