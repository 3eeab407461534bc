// Rods that start with a spin turn as rigid bodies, whatever their shape.
#include "diagnostics/observables.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skein {
namespace {

const Vec3d drift{0.3, -0.2, 0.1}, turning{2, -5, 3};

/// Straight, curved, tapered, elliptic with unequal elements, a ring, a capsule and a body of several parts; each with
/// a place and direction of its own.
std::vector<RodSpec> free_rods() {
    std::vector<RodSpec> rods(4, test::simple_rod(11));
    rods[1].shape.start_curvature = Vec3d{2, -1, 3};
    rods[2].section.taper = 0.2;
    rods[2].shape.rest_curvature = {3, 0, 0};
    rods[3].shape.closed = true;
    rods.push_back(test::crooked_rod(7));
    rods.push_back(test::rigid_body(0.3, 0.05));
    rods.push_back(test::crooked_body());
    for (RodSpec& rod : rods) {
        rod.placement.origin = {1, -2, 0.5};
        rod.placement.tangent = {1, 0.5, 0.3};
        rod.shape.velocity = drift;
        rod.shape.angular_velocity = turning;
    }
    return rods;
}

std::vector<Slot<1>> start_of(const RodGroup& group) {
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    group.start_state(0, state);
    return state;
}

/// The tensor of inertia of the discrete masses about their centre, applied to `w`.
Vec3d inertia_times(const RodGroup& group, const std::vector<Slot<1>>& state, const Vec3d& centre, const Vec3d& w) {
    Vec3d sum{0, 0, 0};
    for (std::size_t i = 0; i < state.size(); ++i) {
        const Vec3d r = lane(state[i].position, 0) - centre;
        sum += group.node_mass[i] * (dot(r, r) * w - dot(r, w) * r);
        if (i == group.element.size()) break;
        const Quaterniond q = lane(state[i].director, 0);
        sum += transpose_times(q, scale(group.element[i].inertia, q * w));
    }
    return sum;
}

TEST(StartState, TurnsAsARigidBody) {
    for (const RodSpec& spec : free_rods()) {
        const RodGroup group(spec, 0, 0, "");
        const auto state = start_of(group);
        Vec3d centre{0, 0, 0};
        double mass = 0;
        for (std::size_t i = 0; i < state.size(); ++i) {
            centre += group.node_mass[i] * lane(state[i].position, 0);
            mass += group.node_mass[i];
        }
        centre = (1 / mass) * centre;
        const Vec3d spin = inertia_times(group, state, centre, turning);
        const RodEnergy energy = rod_energy(group, state);
        const double kinetic = 0.5 * mass * dot(drift, drift) + 0.5 * dot(turning, spin);
        EXPECT_NEAR(energy.translation + energy.rotation, kinetic, 1e-13 * kinetic);
        const test::Momenta momenta = test::momenta(group, state);
        EXPECT_LT(norm(momenta.linear - mass * drift), 1e-13 * norm(mass * drift));
        const Vec3d angular = spin + cross(centre, mass * drift);
        EXPECT_LT(norm(momenta.angular - angular), 1e-13 * norm(angular));
        // Nothing is strained by it: neither lengths nor the angles between directors and edges change.
        for (std::size_t k = 0; k + 1 < state.size(); ++k) {
            const Quaterniond q = lane(state[k].director, 0);
            const Vec3d edge = lane(state[k + 1].position, 0) - lane(state[k].position, 0),
                        rate = lane(state[k + 1].velocity, 0) - lane(state[k].velocity, 0);
            EXPECT_LT(norm(q * rate - cross(lane(state[k].spin, 0), q * edge)), 1e-13 * norm(turning));
        }
    }
}

/// Rods of a list spin about the same axis of the lab, wherever they point: as lone ones that are laid out in their own
/// direction.
TEST(StartState, RodsOfTheirOwnDirectionsTurnInTheLab) {
    const std::vector<Vec3d> origins = {{0, 0, 0}, {1, -2, 0.5}, {3, 0.1, 0}},
                             tangents = {{1, 0.5, 0.3}, {0, 0, -2}, {-1, 0.1, 4}},
                             normals = {{0, 1, 0}, {1, 1, 1}, {1, 0, 0}};
    for (RodSpec spec : free_rods())
        for (const auto& [start, end] : {std::pair{EndKind::free, EndKind::free},
                                         {EndKind::clamped, EndKind::free},
                                         {EndKind::free, EndKind::pinned},
                                         {EndKind::clamped_frozen, EndKind::free}}) {
            const bool held = start != EndKind::free || end != EndKind::free;
            if (held && (spec.shape.closed || spec.body)) continue;
            spec.start = start;
            spec.end = end;
            spec.shape.element_spin = {0.1, 0.2, 0.3};
            RodSpec listed = spec;
            listed.placement = {
                .kind = PlacementKind::list, .origins = origins, .tangents = tangents, .normals = normals};
            const RodGroup group(listed, 0, 0, "");
            ASSERT_TRUE(group.turned());
            for (std::size_t i = 0; i < origins.size(); ++i) {
                spec.placement = {.origin = origins[i], .tangent = tangents[i], .normal = normals[i]};
                const auto expected = start_of(RodGroup(spec, 0, 0, ""));
                std::vector<Slot<1>> state(expected.size());
                group.start_state(static_cast<std::int64_t>(i), state);
                for (std::size_t k = 0; k < state.size(); ++k) {
                    EXPECT_LT(norm(lane(state[k].position, 0) - lane(expected[k].position, 0)), 1e-14);
                    EXPECT_LT(norm(lane(state[k].velocity, 0) - lane(expected[k].velocity, 0)), 1e-13);
                    EXPECT_LT(norm(lane(state[k].spin, 0) - lane(expected[k].spin, 0)), 1e-13);
                    const double along = dot(lane(state[k].director, 0), lane(expected[k].director, 0));
                    EXPECT_NEAR(std::abs(along), 1, 1e-14);
                }
            }
        }
}

// The discrete rod has the mass of the continuous one, and its inertia with an error that falls by four as elements are
// doubled.
TEST(StartState, MeetsTheContinuousRod) {
    const double length = 1, radius = 0.02, mass = 1000 * std::numbers::pi * radius * radius * length;
    const double across = mass * (length * length / 12 + 0.25 * radius * radius), along = 0.5 * mass * radius * radius;
    const auto errors = [&](long n) {
        RodSpec spec = test::simple_rod(n);
        spec.shape.angular_velocity = turning; // the rod lies along z
        const RodGroup group(spec, 0, 0, "");
        const auto state = start_of(group);
        const Vec3d momentum{across * turning.x, across * turning.y, along * turning.z};
        const Vec3d found =
            test::momenta(group, state).angular - cross({0, 0, 0.5 * length}, test::momenta(group, state).linear);
        EXPECT_NEAR(found.z, momentum.z, 1e-13 * momentum.z);
        const RodEnergy energy = rod_energy(group, state);
        return std::pair(norm(found - momentum) / norm(momentum),
                         std::abs(energy.translation + energy.rotation - 0.5 * dot(turning, momentum)));
    };
    const auto [coarse, coarse_energy] = errors(20);
    const auto [fine, fine_energy] = errors(40);
    EXPECT_NEAR(coarse / fine, 4, 0.01);
    EXPECT_NEAR(coarse_energy / fine_energy, 4, 0.01);
    EXPECT_LT(errors(2000).first, 1e-6);
}

TEST(StartState, TurnsAboutThePinThatHoldsIt) {
    for (const bool at_start : {true, false}) {
        RodSpec spec = test::crooked_rod(6);
        (at_start ? spec.start : spec.end) = EndKind::pinned;
        spec.shape.angular_velocity = turning;
        const RodGroup group(spec, 0, 0, "");
        const auto state = start_of(group);
        const Vec3d pin = lane(state[at_start ? 0 : 6].position, 0);
        for (const auto& s : state)
            EXPECT_LT(norm(lane(s.velocity, 0) - cross(turning, lane(s.position, 0) - pin)), 1e-14 * norm(turning));
    }
}

TEST(StartState, SpinsElementsInTheirPlaces) {
    RodSpec spec = test::crooked_rod(5);
    spec.shape.element_spin = {1, 2, 3};
    const RodGroup group(spec, 0, 0, "");
    const auto state = start_of(group);
    for (std::size_t k = 0; k < 5; ++k) {
        EXPECT_EQ(norm(lane(state[k].spin, 0) - spec.shape.element_spin), 0);
        EXPECT_EQ(norm(lane(state[k].velocity, 0)), 0);
    }
}

} // namespace
} // namespace skein
