// Rigid bodies alone: masses and inertia against integrals, a free capsule against the closed form of the symmetric top.
#include "rod/rigid.hpp"

#include "diagnostics/observables.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

/// Mass, J1 and J3 by Simpson's rule over slices of a capsule; on the round ends over the angle, where all is smooth.
Vec3d by_slices(double length, double r) {
    constexpr int n = 2000;
    double mass = 0, j1 = 0, j3 = 0;
    const auto add = [&](double z, double a, double dz) {
        const double slice = 1000 * pi * a * a * dz;
        mass += slice, j1 += slice * (0.25 * a * a + z * z), j3 += slice * 0.5 * a * a;
    };
    for (int i = 0; i <= n; ++i) {
        const double weight = (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) / (3.0 * n), x = static_cast<double>(i) / n;
        add(length * (x - 0.5), r, weight * length);
        const double angle = 0.5 * pi * x;
        for (int end = 0; end < 2; ++end)
            add(0.5 * length + r * std::sin(angle), r * std::cos(angle), weight * 0.5 * pi * r * std::cos(angle));
    }
    return {mass, j1, j3};
}

TEST(Rigid, HasTheMassAndInertiaOfACapsule) {
    for (const double length : {0.01, 0.3, 2.0}) {
        const RodGroup group(test::rigid_body(length, 0.1), 0, 0, "");
        const Vec3d exact = by_slices(length, 0.1);
        EXPECT_NEAR(group.node_mass[0] + group.node_mass[1], exact.x, 1e-10 * exact.x);
        EXPECT_NEAR(group.element[0].inertia.x, exact.y, 1e-10 * exact.y);
        EXPECT_EQ(group.element[0].inertia.y, group.element[0].inertia.x);
        EXPECT_NEAR(group.element[0].inertia.z, exact.z, 1e-10 * exact.z);
    }
    const RodGroup ball(test::rigid_body(0, 0.1), 0, 0, "");
    const double mass = 1000 * 4.0 / 3 * pi * 1e-3;
    EXPECT_NEAR(ball.node_mass[0] + ball.node_mass[1], mass, 1e-6 * mass);
    for (const double j : {ball.element[0].inertia.x, ball.element[0].inertia.z}) EXPECT_NEAR(j, 0.4 * mass * 0.01, 3e-6 * j);
}

// d3 goes round the angular momentum L at |L|/J1, and w about d3 at (1 - J3/J1) w3.
TEST(Rigid, TurnsAsAFreeSymmetricTop) {
    RodSpec spec = test::rigid_body(0.3, 0.05);
    spec.shape.velocity = {0.3, -0.2, 0.1};
    spec.placement.origin = {1, 2, -1};
    spec.placement.tangent = {1, 0.5, 0.3};
    spec.shape.angular_velocity = transpose_times(RodGroup(spec, 0, 0, "").frame(), Vec3d{3, -1, 7});
    const RodGroup group(spec, 0, 0, "");
    std::vector<Slot<1>> state(2);
    group.start_state(0, state);
    const RodTile<1> tile = tile_of(group, state);
    const ExtraFigures before = extra_figures(group, state, {.angular_momentum = true});
    const RodEnergy start = rod_energy(group, state);
    const Vec3d d3 = frame(state[0]).d3,
                spin = lane(transpose_times(state[0].director, scale(broadcast<1>(group.element[0].inertia), state[0].spin)), 0);

    const double h = 1e-3;
    constexpr int steps = 100000;
    KicksOfGroup kicks{KickConstants(group, {}, h)};
    const RigidDriftPass<1> drift_pass;
    const RigidRestPass<1> rest;
    const OrthonormalisePass<1> orthonormalise;
    const RigidKickPass<1> kick(kicks);
    std::vector<SlotLoad<1>> load(2);
    for (int i = 1; i <= steps; ++i) {
        const Step step{.index = i,
                        .dt = h,
                        .drift = h,
                        .kick = h,
                        .time = i * h,
                        .kick_length = 0,
                        .slot = 0,
                        .completes = true,
                        .last = false};
        drift_pass.run(tile, load.data(), step);
        orthonormalise.run(tile, load.data(), step);
        rest.run(tile, load.data(), step);
        kick.run(tile, load.data(), step);
    }

    const RodEnergy end = rod_energy(group, state);
    EXPECT_NEAR(end.translation, start.translation, 1e-11 * start.translation);
    EXPECT_NEAR(end.rotation, start.rotation, 1e-11 * start.rotation);
    EXPECT_EQ(end.elastic(), 0);
    const ExtraFigures after = extra_figures(group, state, {.angular_momentum = true});
    const double mass = group.node_mass[0] + group.node_mass[1], speed = norm(spec.shape.velocity),
                 orbital = mass * (speed * h * steps) * speed; // kg m^2/s
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(after.sum[i], before.sum[i], 1e-12 * (orbital + norm(spin))) << i;

    const double angle = norm(spin) / group.element[0].inertia.x * (h * steps); // 52 turns
    EXPECT_GT(angle, 300);
    const Vec3d axis = (1 / norm(spin)) * spin, along = dot(d3, axis) * axis, across = d3 - along;
    const Vec3d exact = along + std::cos(angle) * across + std::sin(angle) * cross(axis, across);
    EXPECT_LT(norm(frame(state[0]).d3 - exact), 1e-9);
    const Vec3d edge = lane(state[1].position - state[0].position, 0), centre = lane(rigid_centre(state.data()).position, 0);
    EXPECT_LT(norm(edge - 0.3 * exact), 1e-9);
    const Vec3d way = centre - Vec3d{1, 2, -1} - 0.15 * d3;
    EXPECT_LT(norm(way - (h * steps) * spec.shape.velocity), 1e-9);
}

TEST(Rigid, TakesForcesOnItsNodesAsForceAndTorque) {
    RodSpec spec = test::rigid_body(0.4, 0.05);
    spec.placement.tangent = {1, 0, 0};
    const RodGroup group(spec, 0, 0, "");
    std::vector<Slot<1>> state(2);
    group.start_state(0, state);
    const double h = 1e-3, rate = 3;
    DampingRates rates{.node = {rate, rate}, .element = {{rate, rate, rate}}, .element_stretched = {}};
    std::vector<SlotLoad<1>> load(2);
    RigidRestPass<1>().run(tile_of(group, state), load.data(), Step{});
    const Vec3d f0{1, 2, 3}, f1{-2, 5, 1}, couple{0.1, -0.2, 0.3};
    load[0].force = broadcast<1>(f0), load[1].force = broadcast<1>(f1), load[0].couple = broadcast<1>(couple);
    RigidKickPass<1>(KicksOfGroup{KickConstants(group, rigid_rates(rates), h)})
        .run(tile_of(group, state), load.data(), Step{.kick_length = 0});
    const double mean = 2 / (2 + rate * h), mass = group.node_mass[0] + group.node_mass[1];
    const Mat3d q = frame(state[0]);
    const Vec3d torque = 0.2 * cross(q.d3, f1 - f0), j = group.element[0].inertia, w = lane(state[0].spin, 0);
    EXPECT_LT(norm(lane(rigid_centre(state.data()).velocity, 0) - (h * mean / mass) * (f0 + f1)), 1e-15);
    EXPECT_NEAR(w.x, h * mean / j.x * (dot(q.d1, torque) + couple.x), 1e-14);
    EXPECT_NEAR(w.y, h * mean / j.y * (dot(q.d2, torque) + couple.y), 1e-14);
    EXPECT_NEAR(w.z, h * mean / j.z * couple.z, 1e-14);
    const Vec3d turning = cross(w.x * q.d1 + w.y * q.d2 + w.z * q.d3, q.d3);
    EXPECT_LT(norm(lane(state[1].velocity - state[0].velocity, 0) - 0.4 * turning), 1e-14);
}

} // namespace
} // namespace skein
