// Markers lie on the surface, as far apart as they are to be.
#include "immersion/markers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {
namespace {

/// Distance of each marker to the nearest other one.
std::vector<double> nearest(const std::vector<Vec3d>& points) {
    std::vector<double> all;
    for (std::size_t i = 0; i < points.size(); ++i) {
        double least = HUGE_VAL;
        for (std::size_t j = 0; j < points.size(); ++j)
            if (j != i) least = std::min(least, norm(points[i] - points[j]));
        all.push_back(least);
    }
    return all;
}

TEST(Markers, OfASphereAreEven) {
    const std::vector<Vec3d> points = sphere_markers(2, 0.25);
    EXPECT_NEAR(static_cast<double>(points.size()), 4 * std::numbers::pi * 4 / 0.0625, 1);
    Vec3d sum{0, 0, 0};
    for (const Vec3d& at : points) {
        EXPECT_NEAR(norm(at), 2, 1e-14);
        sum += at;
    }
    EXPECT_LT(norm(sum), 1e-2 * static_cast<double>(points.size()));
    for (const double apart : nearest(points)) {
        EXPECT_GT(apart, 0.6 * 0.25);
        EXPECT_LT(apart, 1.2 * 0.25);
    }
}

TEST(Markers, OfATubeHaveEqualArcs) {
    for (const double b : {1.0, 0.3}) {
        const std::vector<Vec3d> points = tube_markers(1, b, -1, 1, 0.1);
        double least = HUGE_VAL, most = 0;
        for (const Vec3d& at : points) EXPECT_NEAR(at.x * at.x + at.y * at.y / (b * b), 1, 1e-5);
        for (const double apart : nearest(points)) {
            least = std::min(least, apart);
            most = std::max(most, apart);
        }
        EXPECT_GT(least, 0.9 * 0.1); // chords of the sharp ends are shorter than their arcs
        EXPECT_LT(most, 1.06 * 0.1);
        EXPECT_NEAR(points.front().z, -0.95, 1e-14);
    }
}

} // namespace
} // namespace skein
