// Segments and boxes: nearest points against a search, what lies beside a face or an edge, and the way out of the
// inside.
#include "contact/box_distance.hpp"

#include <gtest/gtest.h>

#include <random>

namespace skein {
namespace {

TEST(BoxDistance, IsTheSmallestAlongTheSegment) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const auto vector = [&] { return Vec3d{normal(random), normal(random), normal(random)}; };
    for (int trial = 0; trial < 3000; ++trial) {
        Vec3d half{std::abs(normal(random)), std::abs(normal(random)), std::abs(normal(random))}, p = 2.0 * vector(),
                                                                                                  d = vector();
        if (trial % 5 == 1) d.x = 0;
        if (trial % 5 == 2) d.x = d.z = 0;
        if (trial % 5 == 3) half.z = 0; // a plate
        if (trial % 5 == 4) p = 1.0 * p - 0.5 * d;
        const SegmentToBox near = nearest_to_box(p, d, half);
        EXPECT_GE(near.s, 0);
        EXPECT_LE(near.s, 1);
        const auto distance = [&](double s) { return std::max(0.0, nearest_on_box(p + s * d, half).distance); };
        double least = HUGE_VAL;
        for (int i = 0; i <= 2000; ++i) least = std::min(least, distance(i / 2000.0));
        EXPECT_LE(distance(near.s), least + 1e-14) << trial;
    }
}

TEST(BoxDistance, OfAPointIsThatToItsFoot) {
    const Vec3d half{1, 2, 3};
    const BoxPoint face = nearest_on_box({0.5, 0.5, 5}, half), corner = nearest_on_box({2, 3, 4}, half),
                   inside = nearest_on_box({0.9, 0, 0}, half);
    EXPECT_EQ(face.distance, 2);
    EXPECT_EQ(face.outwards.z, 1);
    EXPECT_EQ(face.on_box.z, 3);
    EXPECT_NEAR(corner.distance, std::sqrt(3.0), 1e-15);
    EXPECT_NEAR(inside.distance, -0.1, 1e-15);
    EXPECT_EQ(inside.outwards.x, 1);
    EXPECT_EQ(inside.on_box.x, 1);
    const SegmentToBox none = nearest_to_box({0, 0, 4}, {0, 0, 0}, half);
    EXPECT_EQ(none.s, 0);
    EXPECT_EQ(none.sine_squared, 1);
}

TEST(BoxDistance, KnowsWhatLiesBesideAFaceOrAnEdge) {
    const Vec3d half{1, 2, 3};
    for (const double tilt : {0.0, 1e-9, -1e-9}) {
        // Over the face z = 3, hanging over at x = 1, which is passed at s = 0.75.
        const SegmentToBox face = nearest_to_box({-0.5, 0, 3.1}, {2, 0, tilt}, half);
        EXPECT_NEAR(face.first, 0, 1e-12);
        EXPECT_NEAR(face.last, 0.75, 1e-12);
        EXPECT_NEAR(face.s, 0.375, 1e-6);
        EXPECT_LT(face.sine_squared, 1e-17);
    }
    // Along the edge at x = 1, z = 3, from y = -4 to 4.
    const SegmentToBox edge = nearest_to_box({1.2, -4, 3.3}, {0, 8, 0}, half);
    EXPECT_NEAR(edge.first, 0.25, 1e-12);
    EXPECT_NEAR(edge.last, 0.75, 1e-12);
    EXPECT_NEAR(edge.s, 0.5, 1e-12);
    EXPECT_EQ(edge.sine_squared, 0);
    // At 30 degrees to a face.
    const SegmentToBox steep = nearest_to_box({0, 0, 3.1}, {0.5 * std::sqrt(3.0), 0, 0.5}, half);
    EXPECT_EQ(steep.s, 0);
    EXPECT_NEAR(steep.sine_squared, 0.25, 1e-12);
}

} // namespace
} // namespace skein
