// Angular momentum, curvature and knots of rods whose values are known in closed form.
#include "diagnostics/extra_observables.hpp"
#include "diagnostics/observables.hpp"
#include "support/rods_for_tests.hpp"
#include "tiles/rods.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skein {
namespace {

using F = ExtraFigures;
constexpr double pi = std::numbers::pi;

Vec3d angular_momentum(const ExtraFigures& f) {
    return {f.sum[F::angular_x], f.sum[F::angular_y], f.sum[F::angular_z]};
}

/// A rod of rest length 1 bent and twisted at constant rates.
std::vector<Slot<1>> bent(const RodGroup& group, const Vec3d& curvature) {
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    const double l = group.element[0].rest_length;
    Quaterniond q = rotation((0.5 * l) * curvature);
    Vec3d x{0, 0, 0};
    for (std::size_t k = 0; k < state.size(); ++k) {
        set_lane(state[k].position, 0, x);
        if (k + 1 == state.size()) break;
        set_lane(state[k].director, 0, q);
        x += l * third_director(q);
        q = rotation(l * curvature) * q;
    }
    return state;
}

TEST(ExtraObservables, AngularMomentumOfARigidlySpinningRod) {
    const RodGroup group(test::crooked_rod(12), 0, 0, "");
    auto state = test::shaken_state(group, 0, 0, 0);
    const Vec3d omega{0.3, -2, 1.1}, drift{1, 2, -3};
    Vec3d expected{0, 0, 0}, moment{0, 0, 0};
    for (std::size_t i = 0; i < state.size(); ++i) {
        const Vec3d x = lane(state[i].position, 0), v = cross(omega, x);
        set_lane(state[i].velocity, 0, v + drift);
        expected += group.node_mass[i] * (dot(x, x) * omega - dot(x, omega) * x); // I omega of points
        moment += group.node_mass[i] * x;
        if (i + 1 == state.size()) break;
        const Mat3d q = frame(state[i]);
        set_lane(state[i].spin, 0, q * omega);
        const Vec3d& j = group.element[i].inertia;
        expected += j.x * dot(q.d1, omega) * q.d1 + j.y * dot(q.d2, omega) * q.d2 + j.z * dot(q.d3, omega) * q.d3;
    }
    expected += cross(moment, drift);
    const Vec3d found = angular_momentum(extra_figures(group, state, {.angular_momentum = true}));
    EXPECT_LT(norm(found - expected), 1e-14 * norm(expected));
}

TEST(ExtraObservables, CurvatureOfAHelicalRod) {
    const RodGroup group(test::simple_rod(20), 0, 0, "");
    const Vec3d curvature{1.2, -0.9, 2};
    const ExtraFigures f = extra_figures(group, bent(group, curvature), {.curvature = true});
    EXPECT_NEAR(f.sum[F::cell_length], 19.0 / 20, 1e-14);
    EXPECT_NEAR(f.sum[F::bend_length] / f.sum[F::cell_length], 1.5, 1e-12);
    EXPECT_NEAR(f.sum[F::twist_length] / f.sum[F::cell_length], 2, 1e-12);
    EXPECT_NEAR(f.extreme[F::bend], 1.5, 1e-12);
    EXPECT_NEAR(f.extreme[F::twist_rate], 2, 1e-12);
    EXPECT_EQ(f.sum[F::angular_x], 0);
    EXPECT_EQ(f.sum[F::writhe], 0);
}

// A straight twisted rod: all of the link is twist. A rod bent in a plane: no twist, no writhe.
TEST(ExtraObservables, TwistOfStraightAndOfPlaneRods) {
    const RodGroup group(test::simple_rod(20), 0, 0, "");
    const ExtraFigures straight = extra_figures(group, bent(group, {0, 0, 8 * pi}), {.knots = true});
    EXPECT_NEAR(straight.sum[F::twist], 4 * 19.0 / 20, 1e-12);
    EXPECT_NEAR(straight.sum[F::writhe], 0, 1e-12);
    const ExtraFigures plane = extra_figures(group, bent(group, {3, 0, 0}), {.knots = true});
    EXPECT_NEAR(plane.sum[F::twist], 0, 1e-12);
    EXPECT_NEAR(plane.sum[F::writhe], 0, 1e-12);
}

// A circle of n cells, the last from element n - 1 to element 0, and the same with its frames turned k times round.
TEST(ExtraObservables, OfARingCountTheCellThatClosesIt) {
    RodSpec spec = test::simple_rod(24);
    spec.shape.closed = true;
    const RodGroup group(spec, 0, 0, "");
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    group.start_state(0, state);
    for (const int turns : {0, 2}) {
        auto turned = state;
        for (std::size_t k = 0; k < 24; ++k)
            set_lane(turned[k].director, 0,
                     rotation({0, 0, 2 * pi * turns * static_cast<double>(k) / 24}) * lane(state[k].director, 0));
        const ExtraFigures f = extra_figures(group, turned, {.curvature = true, .knots = true});
        EXPECT_NEAR(f.sum[F::cell_length], 1, 1e-14);
        EXPECT_NEAR(f.sum[F::twist], turns, 1e-12);
        EXPECT_NEAR(f.sum[F::writhe], 0, 1e-12);
        if (turns > 0) continue;
        EXPECT_NEAR(f.sum[F::bend_length], 2 * pi, 1e-12);
        EXPECT_NEAR(f.extreme[F::bend], 2 * pi, 1e-12);
        EXPECT_NEAR(f.extreme[F::twist_rate], 0, 1e-12);
    }
}

TEST(Observables, StandWhereTheirNamesSay) {
    const auto names = observable_names();
    EXPECT_EQ(names[observed_energies - 1], "elastic_twist[J]");
    EXPECT_EQ(names[observed_axial_strain], "max_axial_strain[-]");
    EXPECT_EQ(names[observed_turn_per_cell], "max_turn_per_cell[rad]");
}

TEST(ExtraObservables, WhatIsNotAskedForIsNotThere) {
    const RodGroup group(test::simple_rod(6), 0, 0, "");
    const auto state = test::shaken_state(group, 0.01, 0.2, 1);
    const ExtraFigures nothing = extra_figures(group, state, {});
    for (const double value : nothing.sum) EXPECT_EQ(value, 0);
    EXPECT_TRUE(extra_names({}).empty());
    EXPECT_EQ(extra_names({.knots = true}).size(), 3u);
    EXPECT_EQ(extra_names({true, true, true, true}).size(), 12u);
}

TEST(ExtraObservables, OrderIsThatOfDirectionsInThePlane) {
    const auto order = [&](const std::vector<double>& degrees) { // S and S_2 of the sums
        F all;
        for (const double angle : degrees) {
            RodSpec spec = test::simple_rod(6);
            const double a = angle * pi / 180;
            spec.placement.tangent = {std::cos(a), std::sin(a), 0.3}; // heights do not count
            const RodGroup group(spec, 0, 0, "");
            std::vector<Slot<1>> state(7);
            group.start_state(0, state);
            const F one = extra_figures(group, state, {.order = true});
            for (std::size_t s = 0; s < all.sum.size(); ++s) all.sum[s] += one.sum[s];
        }
        const double rods = all.sum[F::directed];
        EXPECT_EQ(rods, static_cast<double>(degrees.size()));
        return std::array{all.sum[F::along_axes] / rods, std::hypot(all.sum[F::cosine], all.sum[F::sine]) / rods};
    };
    const auto expect = [&](const std::vector<double>& degrees, double along_axes, double one_line) {
        const auto found = order(degrees);
        EXPECT_NEAR(found[0], along_axes, 1e-12);
        EXPECT_NEAR(found[1], one_line, 1e-12);
    };
    expect({0, 90, 180, 270}, 1, 0);
    expect({30, 30, 210}, 0.5, 1);
    expect({45, 135}, 0, 0);
    expect({0, 0, 90}, 1, 1.0 / 3);
    std::vector<double> even;
    for (int i = 0; i < 3600; ++i) even.push_back(0.1 * i);
    EXPECT_NEAR(order(even)[0], 2 / pi, 1e-5);
}

} // namespace
} // namespace skein
