// End weights: who has them, what they leave as it is, and that the limits of the step bound what they make of the
// frequencies.
#include "rod/end_weights.hpp"

#include "diagnostics/extra_observables.hpp"
#include "diagnostics/observables.hpp"
#include "mechanics/present_eigenvalues.hpp"
#include "rod/time_limits.hpp"
#include "support/rods_for_tests.hpp"
#include "support/statics.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

constexpr EndKind all_ends[] = {EndKind::free, EndKind::pinned, EndKind::clamped, EndKind::clamped_frozen};

RodSpec weighted(long n, EndKind start = EndKind::free, EndKind end = EndKind::free) {
    RodSpec spec = test::simple_rod(n);
    spec.start = start;
    spec.end = end;
    spec.shape.end_weights = EndWeights::gregory;
    return spec;
}
RodSpec plain(RodSpec spec) {
    spec.shape.end_weights = EndWeights::plain;
    return spec;
}
RodGroup group_of(const RodSpec& spec) { return RodGroup(spec, 0, 0, ""); }

TEST(EndWeights, AreThoseOfTheirEnds) {
    for (const EndKind start : all_ends)
        for (const EndKind end : all_ends) {
            const RodSpec spec = weighted(9, start, end);
            const RodGroup group = group_of(spec), other = group_of(plain(spec));
            const bool published = start == EndKind::clamped_frozen || end == EndKind::clamped_frozen;
            const double weight[] = {0.75, 7.0 / 6, 23.0 / 24};
            double mass = 0;
            for (std::size_t i = 0; i < 10; ++i) {
                const std::size_t from_end = std::min(i, 9 - i);
                const EndKind near = i < 5 ? start : end;
                const double w = published || from_end > 2 ? 1 : weight[from_end];
                const double mass_weight = near == EndKind::free ? w : 1, of_cell = near == EndKind::pinned ? 1 : w;
                EXPECT_DOUBLE_EQ(group.node_mass[i], mass_weight * other.node_mass[i]);
                EXPECT_DOUBLE_EQ(group.node_length[i], mass_weight * other.node_length[i]);
                const auto stiffness = [&](const RodGroup& g) {
                    return (i == 0 ? g.start_wall : i == 9 ? g.end_wall : g.voronoi[i - 1]).stiffness.x;
                };
                EXPECT_DOUBLE_EQ(of_cell * stiffness(group), stiffness(other)) << i;
                mass += group.node_mass[i];
            }
            const double whole = 1000 * std::numbers::pi * 0.02 * 0.02;
            EXPECT_NEAR(mass, whole, 1e-14 * whole);
        }
}

TEST(EndWeights, ArePlainWhereTheyDoNotHold) {
    std::vector<RodSpec> specs(8, weighted(9, EndKind::clamped));
    specs[0].shape.elements = 5;
    specs[1].shape.length_profile.assign(9, 1.0);
    specs[2].section.taper = 0.5;
    specs[3].section.profile.assign(9, 1.0);
    specs[4].material.law = Law::elastica;
    specs[5].shape.rest_curvature = {0, 1, 0};
    specs[6].start = EndKind::free;
    specs[6].shape.closed = true;
    specs[7].shape.rest_curvature_profile.assign(8, Vec3d{0, 0, 1});
    for (const RodSpec& spec : specs) {
        const RodGroup group = group_of(spec), other = group_of(plain(spec));
        EXPECT_EQ(group.node_mass, other.node_mass);
        EXPECT_TRUE(group.cell_weight.empty());
        EXPECT_EQ(group.nodal_density, other.nodal_density);
        EXPECT_EQ(group.start_wall.stiffness.x, other.start_wall.stiffness.x);
        for (std::size_t k = 0; k < group.voronoi.size(); ++k)
            EXPECT_EQ(group.voronoi[k].stiffness.x, other.voronoi[k].stiffness.x);
    }
}

// The trapezoid rule makes them 1 + 2/n^2 times as large.
TEST(EndWeights, GiveAFreeRodTheMomentOfInertiaOfItsLine) {
    for (const long n : {6L, 7L, 20L})
        for (const EndKind start : {EndKind::free, EndKind::pinned}) {
            const RodGroup group = group_of(weighted(n, start));
            double mass = 0, second = 0;
            for (std::size_t i = 0; i < group.node_mass.size(); ++i) {
                const double s = static_cast<double>(i) / static_cast<double>(n) - (start == EndKind::free ? 0.5 : 0);
                mass += group.node_mass[i];
                second += group.node_mass[i] * s * s;
            }
            EXPECT_NEAR(second / mass, start == EndKind::free ? 1.0 / 12 : 1.0 / 3, 1e-14) << n;
        }
}

// A start shape of one curvature has its energy, and observables its curvature.
TEST(EndWeights, HoldABentRodByItsCurvature) {
    for (const EndKind start : {EndKind::free, EndKind::clamped, EndKind::pinned})
        for (const EndKind end : {EndKind::free, EndKind::clamped, EndKind::pinned}) {
            RodSpec spec = weighted(12, start, end);
            spec.material.law = Law::linear;
            spec.shape.start_curvature = Vec3d{1.2, -0.9, 2};
            const RodGroup group = group_of(spec);
            std::vector<Slot<1>> state(13);
            group.start_state(0, state);
            using F = ExtraFigures;
            const ExtraFigures f = extra_figures(group, state, {.curvature = true});
            EXPECT_NEAR(f.sum[F::bend_length] / f.sum[F::cell_length], 1.5, 1e-12);
            EXPECT_NEAR(f.extreme[F::bend], 1.5, 1e-12);
            EXPECT_NEAR(f.extreme[F::twist_rate], 2, 1e-12);
            if (start != EndKind::clamped || end != EndKind::clamped) continue;
            const Vec3d b = group.element[0].bending;
            const double exact = 0.5 * (b.x * 1.2 * 1.2 + b.y * 0.9 * 0.9 + b.z * 4);
            const RodEnergy u = rod_energy(group, state);
            EXPECT_NEAR(u.elastic(), exact, 1e-9 * exact);
        }
}

TEST(EndWeights, LimitsBoundTheLargestFrequencyAndAreNear) {
    for (const EndWeights weights : {EndWeights::plain, EndWeights::gregory})
        for (const EndKind start : {EndKind::free, EndKind::pinned, EndKind::clamped})
            for (const EndKind end : {EndKind::free, EndKind::pinned, EndKind::clamped})
                for (const double aspect : {4.0, 60.0})
                    for (const long n : {6L, 9L}) {
                        RodSpec spec = weighted(n, start, end);
                        spec.shape.end_weights = weights;
                        spec.section.radius = 0.5 / aspect;
                        const RodGroup group = group_of(spec);
                        const double limit = time_limits(group).front().dt;
                        for (const TimeLimit& mode : time_limits(group)) {
                            const bool axial = mode.mode == "axial", twist = mode.mode == "twist";
                            const double share =
                                0.5 * mode.dt * test::Statics(group).largest_frequency([&](bool turns, int axis) {
                                    return axial || twist ? axis == 2 && turns == twist : axis == (turns ? 1 : 0);
                                });
                            EXPECT_LT(share, 1 + 1e-6) << mode.mode << " " << aspect << " " << n;
                            EXPECT_GT(share, axial ? 0.96 : 0.92) << mode.mode << " " << aspect << " " << n;
                        }
                        std::vector<Slot<1>> state(static_cast<std::size_t>(n) + 1);
                        group.start_state(0, state);
                        const double watched = 2 / std::sqrt(largest_eigenvalue(test::tile_of(group, state))[0]);
                        EXPECT_NEAR(watched, limit, 1e-9 * limit);
                    }
}

} // namespace
} // namespace skein
