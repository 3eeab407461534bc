// Markers of rods lie within the surface, as far apart as they are to be, and close both ends.
#include "immersion/rod_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

RodGroup rod(SectionKind kind, double a, double b, double length, double taper = 1) {
    RodSpec spec;
    spec.material = {.density = 1, .youngs_modulus = 1};
    spec.section = {.kind = kind, .radius = a, .radius_2 = b, .taper = taper};
    spec.shape.length = length;
    spec.shape.elements = 20;
    return {spec, 0, 0, "."};
}

FluidGrid grid_of(double h) {
    FluidGrid grid;
    grid.h = h;
    grid.cells = {40, 8, 40};
    grid.boundary = {FluidBoundary::free_slip, FluidBoundary::periodic, FluidBoundary::free_slip};
    return grid;
}

/// In the frame of a straight rod along z.
std::vector<Vec3d> places(const RodGroup& group, const std::vector<RodMarker>& markers) {
    std::vector<Vec3d> all;
    for (const RodMarker& m : markers) {
        EXPECT_LT(m.element, group.element.size());
        EXPECT_GE(m.along, 0);
        EXPECT_LE(m.along, 1);
        all.push_back({m.off_d1, m.off_d2, (m.element + m.along) * group.element[m.element].rest_length});
    }
    return all;
}

TEST(RodSurface, RingsAndCapsOfARoundRod) {
    const double h = 0.1, retraction = 0.04, radius = 0.5, length = 3;
    const RodGroup group = rod(SectionKind::circular, radius, 0, length);
    const std::vector<Vec3d> all = places(group, rod_markers(group, grid_of(h), retraction));
    const double inner = radius - retraction,
                 surface = 2 * pi * inner * (length - 2 * retraction) + 2 * pi * inner * inner;
    EXPECT_NEAR(static_cast<double>(all.size()), surface / (h * h), 0.05 * surface / (h * h));
    Vec3d sum{0, 0, 0};
    for (const Vec3d& at : all) {
        const double off = std::hypot(at.x, at.y);
        const bool side = std::abs(off - inner) < 1e-6, start = std::abs(at.z - retraction) < 1e-12,
                   end = std::abs(at.z - length + retraction) < 1e-12;
        EXPECT_TRUE(side || ((start || end) && off < inner)) << at.x << " " << at.y << " " << at.z;
        double nearest = HUGE_VAL;
        for (const Vec3d& other : all)
            if (&other != &at) nearest = std::min(nearest, norm(other - at));
        EXPECT_GT(nearest, 0.45 * h);
        EXPECT_LT(nearest, 1.3 * h);
        sum += at - Vec3d{0, 0, 0.5 * length};
    }
    EXPECT_LT(norm(sum), 1e-5);
}

TEST(RodSurface, ThinSectionsAreSheetsAndThreadsAreLines) {
    const double h = 0.1, retraction = 0.04;
    EXPECT_EQ(section_markers({0.3, 0.3}, h, retraction), SectionMarkers::ring);
    EXPECT_EQ(section_markers({0.09, 0.4}, h, retraction), SectionMarkers::ring);
    EXPECT_EQ(section_markers({0.06, 0.4}, h, retraction), SectionMarkers::sheet);
    EXPECT_EQ(section_markers({0.06, 0.08}, h, retraction), SectionMarkers::centre_line);
    const RodGroup flat = rod(SectionKind::elliptic, 0.06, 0.4, 2), thread = rod(SectionKind::circular, 0.05, 0, 2);
    for (const RodMarker& m : rod_markers(flat, grid_of(h), retraction)) {
        EXPECT_EQ(m.off_d1, 0);
        EXPECT_LT(std::abs(m.off_d2), 0.4 - retraction);
    }
    const std::vector<RodMarker> line = rod_markers(thread, grid_of(h), retraction);
    EXPECT_NEAR(static_cast<double>(line.size()), 2 / h, 1.5);
    for (const RodMarker& m : line) EXPECT_EQ(std::hypot(m.off_d1, m.off_d2), 0);
}

TEST(RodSurface, ARectangularSectionHasFourSides) {
    const double h = 0.1, retraction = 0.04, a = 0.3, b = 0.25, length = 2;
    const RodGroup bar = rod(SectionKind::rectangular, a, b, length);
    EXPECT_FALSE(spans_box(bar, grid_of(h)));
    const std::vector<Vec3d> all = places(bar, rod_markers(bar, grid_of(h), retraction));
    const double x = a - retraction, y = b - retraction, ends = retraction + 1e-12;
    std::int64_t on_side[2][2] = {};
    for (const Vec3d& at : all) {
        EXPECT_LE(std::abs(at.x), x + 1e-12);
        EXPECT_LE(std::abs(at.y), y + 1e-12);
        if (at.z <= ends || at.z >= length - ends) continue;
        const bool across_d1 = std::abs(std::abs(at.x) - x) < 1e-12, across_d2 = std::abs(std::abs(at.y) - y) < 1e-12;
        EXPECT_TRUE(across_d1 != across_d2) << at.x << " " << at.y;
        ++on_side[across_d2][(across_d1 ? at.x : at.y) > 0];
    }
    const auto rings = std::lround((length - 2 * retraction) / h) - 1;
    for (int upper = 0; upper < 2; ++upper) {
        EXPECT_EQ(on_side[0][upper], rings * std::lround(2 * y / h));
        EXPECT_EQ(on_side[1][upper], rings * std::lround(2 * x / h));
    }
}

/// Two sides in a periodic box that is as wide, one a cell, so that the fluid cannot tell it from one without end.
TEST(RodSurface, APlateAsWideAsAPeriodicBoxHasNoEdges) {
    const double h = 0.1, retraction = 0.04, a = 0.2;
    const RodGroup plate = rod(SectionKind::rectangular, a, 0.4, 2);
    EXPECT_TRUE(spans_box(plate, grid_of(h))) << "d2 is along y, across which the box has 8 cells and is periodic";
    EXPECT_FALSE(spans_box(rod(SectionKind::rectangular, a, 0.39, 2), grid_of(h)));
    EXPECT_FALSE(spans_box(rod(SectionKind::elliptic, a, 0.4, 2), grid_of(h)));
    std::vector<double> across;
    for (const Vec3d& at : places(plate, rod_markers(plate, grid_of(h), retraction)))
        if (at.z > 1 && at.z < 1.1) {
            EXPECT_NEAR(std::abs(at.x), a - retraction, 1e-12);
            if (at.x > 0) across.push_back(at.y);
        }
    ASSERT_EQ(across.size(), 8u);
    std::sort(across.begin(), across.end());
    for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(across[i], -0.35 + 0.1 * static_cast<double>(i), 1e-12);
}

/// One cell of depth has what each cell of a deeper box has: sheets of thin plates, two sides and caps of thick ones.
TEST(RodSurface, APlateIsAsThickHoweverDeepTheBox) {
    const double h = 0.1, retraction = 0.04;
    for (const double a : {0.02, 0.06, 0.08, 0.2, 0.45}) {
        const auto of_depth = [&](int cells) {
            FluidGrid grid = grid_of(h);
            grid.cells[1] = cells;
            const RodGroup plate = rod(SectionKind::rectangular, a, 0.5 * h * cells, 2);
            EXPECT_TRUE(spans_box(plate, grid));
            return places(plate, rod_markers(plate, grid, retraction));
        };
        const std::vector<Vec3d> one = of_depth(1);
        double most = 0;
        for (const Vec3d& at : one) most = std::max(most, std::abs(at.x));
        EXPECT_NEAR(most, a - retraction < 0.3 * h ? 0 : a - retraction, 1e-12) << a;
        for (const int cells : {2, 3, 4, 8}) {
            std::vector<Vec3d> deep = of_depth(cells);
            ASSERT_EQ(deep.size(), one.size() * static_cast<std::size_t>(cells)) << a;
            for (std::size_t m = 0; m < deep.size(); ++m) {
                const Vec3d& at = one[m / static_cast<std::size_t>(cells)];
                EXPECT_NEAR(deep[m].x, at.x, 1e-12) << a << " " << cells << " " << m;
                EXPECT_NEAR(deep[m].z, at.z, 1e-12) << a << " " << cells << " " << m;
            }
        }
    }
}

/// Sections between middles of elements are those of the taper.
TEST(RodSurface, FollowsATaper) {
    const double h = 0.02, retraction = 0.008;
    const RodGroup group = rod(SectionKind::elliptic, 0.3, 0.15, 2, 0.5);
    for (const Vec3d& at : places(group, rod_markers(group, grid_of(h), retraction))) {
        if (at.z < 0.1 || at.z > 1.9) continue;
        const double scale = 1 - 0.25 * at.z, a = 0.3 * scale - retraction, b = 0.15 * scale - retraction;
        EXPECT_NEAR(at.x * at.x / (a * a) + at.y * at.y / (b * b), 1, 1e-3);
    }
}

/// From 3 cells of half the thickness to 0.06. Markers begin where a part is one cell thick.
TEST(RodSurface, IsSharpDownToOneCellOfThickness) {
    const double h = 0.05, retraction = 0.02;
    const RodGroup group = rod(SectionKind::elliptic, 0.3, 0.15, 2, 0.02);
    const std::vector<double> sharp = sharp_shares(group, grid_of(h));
    ASSERT_EQ(sharp.size(), 21U);
    const auto half_thickness = [&](double s) { return 0.15 * (1 - 0.49 * s) / h; };
    for (std::size_t i = 1; i < 20; ++i) { // sections of end nodes are those of their elements
        const double half = half_thickness(0.1 * static_cast<double>(i));
        EXPECT_NEAR(sharp[i], std::clamp((half - 0.25) / 0.25, 0.0, 1.0), 1e-9) << i;
        if (i > 1) EXPECT_LE(sharp[i], sharp[i - 1]) << i;
    }
    EXPECT_EQ(sharp.front(), 1);
    EXPECT_EQ(sharp.back(), 0);
    const std::vector<RodMarker> all = rod_markers(group, grid_of(h), retraction),
                                 some = rod_markers(group, grid_of(h), retraction, sharp);
    std::size_t kept = 0;
    for (const RodMarker& m : all) {
        const double share = 1 - ((1 - m.along) * sharp[m.element] + m.along * sharp[m.element + 1]);
        if (share == 0) continue;
        ASSERT_LT(kept, some.size());
        EXPECT_EQ(some[kept].element, m.element);
        EXPECT_EQ(some[kept].off_d1, m.off_d1);
        EXPECT_DOUBLE_EQ(some[kept].share, share);
        ++kept;
    }
    EXPECT_EQ(kept, some.size());
    EXPECT_GT(kept, 0U);
    EXPECT_LT(kept, all.size());
    EXPECT_TRUE(sharp_shares(rod(SectionKind::elliptic, 0.3, 0.049, 2), grid_of(h)).empty());
    EXPECT_FALSE(sharp_shares(rod(SectionKind::elliptic, 0.3, 0.051, 2), grid_of(h)).empty());
}

} // namespace
} // namespace skein
