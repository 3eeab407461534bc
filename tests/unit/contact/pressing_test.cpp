// What presses contacts, from weight and pressure, and the overlap and stiffness that go with it.
#include "contact/pressing.hpp"
#include "placement/packing.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

constexpr Vec3d down{0, 0, -9.81};

/// `columns` x `columns` piles of `layers` rods 1 m long that lie across each other.
std::vector<RodGroup> piles(long columns, int layers, long elements = 8) {
    std::vector<RodGroup> groups;
    std::int64_t first = 0;
    for (int layer = 0; layer < layers; ++layer) {
        RodSpec spec = test::simple_rod(elements);
        const bool along_x = layer % 2 == 0;
        spec.placement = {.kind = PlacementKind::lattice,
                          .origin = {along_x ? -0.5 : 0.0, along_x ? 0.0 : -0.5, 0.04 * layer},
                          .tangent = {along_x ? 1.0 : 0.0, along_x ? 0.0 : 1.0, 0},
                          .counts = {columns, columns},
                          .spacing = {1.0, 1.0}};
        groups.emplace_back(spec, layer, first, "");
        first += groups.back().count();
    }
    return groups;
}

double force_of(const std::vector<RodGroup>& groups, const Vec3d& gravity, double pressure = 0, double area = 0) {
    return pressing(groups, std::vector<Vec3d>(groups.size(), gravity), pressure, area).force;
}

double rod_weight(const RodGroup& group) {
    double volume = 0;
    for (const ElementConstants& c : group.element) volume += c.volume;
    return group.spec().material.density * volume * norm(down);
}

TEST(Pressing, OverlapAndStiffnessAreEachOthersInverse) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (const double force : {1e-3, 1.0, 400.0})
            for (const double overlap : {1e-5, 1e-3}) {
                const ContactLaw law{.normal = normal, .stiffness = stiffness_for(normal, force, overlap)};
                EXPECT_NEAR(overlap_under(law, force) / overlap, 1, 1e-14);
                EXPECT_NEAR(law.stiffness * (normal == ContactNormal::linear ? overlap : std::pow(overlap, 1.5)) /
                                force,
                            1, 1e-14);
            }
}

TEST(Pressing, OfNothingIsNothing) {
    EXPECT_EQ(force_of(piles(2, 2), {0, 0, 0}), 0);
    EXPECT_FALSE(pressing(piles(2, 2), std::vector<Vec3d>(2, Vec3d{0, 0, 0}), 0, 0).of_lid);
}

TEST(Pressing, IsBetweenOneRodAndAll) {
    const auto two = piles(1, 2);
    EXPECT_GE(force_of(two, down), (1 - 1e-14) * rod_weight(two[0]));
    EXPECT_LE(force_of(two, down), 2 * rod_weight(two[0]));
    EXPECT_NEAR(force_of(two, 3 * down) / force_of(two, down), 3, 1e-12);
    EXPECT_NEAR(force_of(two, {9.81, 0, 0}) / force_of(two, {0, 9.81, 0}), 1, 1e-12);
}

TEST(Pressing, GrowsWithHeightAndHardlyWithExtent) {
    const double low = force_of(piles(6, 4), down), high = force_of(piles(6, 8), down),
                 wide = force_of(piles(12, 4), down);
    EXPECT_GT(high / low, 2);
    EXPECT_LT(high / low, 2.4);
    EXPECT_GT(wide / low, 0.8);
    EXPECT_LT(wide / low, 1.5);
}

TEST(Pressing, OfPilesFarApartIsThatOfOne) {
    auto spread = piles(6, 4);
    for (RodGroup& group : spread) {
        RodSpec spec = group.spec();
        spec.placement.spacing = {7, 7};
        group = RodGroup(spec, group.id(), group.first_gid(), "");
    }
    const double one = force_of(piles(1, 4), down), many = force_of(spread, down);
    EXPECT_GT(many / one, 0.9);
    EXPECT_LT(many / one, 3);
}

TEST(Pressing, DoesNotDependOnHowManyElementsThereAre) {
    EXPECT_NEAR(force_of(piles(3, 4, 8), down) / force_of(piles(3, 4, 64), down), 1, 1e-12);
}

TEST(Pressing, OfALidIsProportionalToItsPressure) {
    const auto groups = piles(6, 4);
    const double light = force_of(groups, down, 1e5, 36), heavy = force_of(groups, down, 3e5, 36);
    EXPECT_NEAR(heavy / light, 3, 1e-12);
    EXPECT_TRUE(pressing(groups, std::vector<Vec3d>(groups.size(), down), 1e5, 36).of_lid);
    EXPECT_EQ(force_of(groups, down, 1e-6, 36), force_of(groups, down));
}

} // namespace
} // namespace skein
