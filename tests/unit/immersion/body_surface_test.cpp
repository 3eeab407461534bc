// Rigid bodies in a fluid: what they displace, and markers within their surfaces.
#include "immersion/body_surface.hpp"

#include "immersion/inertia_in_fluid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {
namespace {

using std::numbers::pi;

RodSpec body_spec() {
    RodSpec spec;
    spec.material.density = 3;
    return spec;
}

template <class Change> BodyShape shape(Change&& change) {
    RodSpec spec = body_spec();
    BodySpec body;
    change(body);
    spec.body = body;
    return BodyShape(spec);
}

BodyShape ball() {
    return shape([](BodySpec& b) { b.spheres.radii = {0.7}; });
}
BodyShape stick() {
    return shape([](BodySpec& b) { b.capsules = {{{-0.5, 0.1, 0}}, {{0.9, 0.3, 0.4}}, {0.4}}; });
}
BodyShape block() {
    return shape([](BodySpec& b) { b.boxes = {{{0.2, 0, 0.1}}, {{1.5, 1.1, 0.8}}, {0.15}}; });
}
/// A ball at one end of a stick, and one apart from both.
BodyShape club() {
    return shape([](BodySpec& b) {
        b.capsules = {{{0, 0, -1}}, {{0, 0, 1}}, {0.3}};
        b.spheres = {{{0, 0, 1}, {0, 2, 0}}, {0.6, 0.5}};
    });
}

double trace(const SymmetricMatrix& m) { return m.xx + m.yy + m.zz; }

TEST(BodySurface, DisplacesTheVolumeOfItsPartsWithTheirInertia) {
    for (const BodyShape& body : {ball(), stick(), block()}) {
        const DisplacedVolume displaced = displaced_volume(body);
        EXPECT_NEAR(displaced.volume, body.volume, 1e-14 * body.volume);
        EXPECT_LT(norm(displaced.centre), 1e-14);
        const SymmetricMatrix& j = displaced.inertia;
        const double largest = std::max({j.xx, j.yy, j.zz});
        EXPECT_NEAR(3 * j.xx, body.inertia.x, 1e-13 * largest);
        EXPECT_NEAR(3 * j.yy, body.inertia.y, 1e-13 * largest);
        EXPECT_NEAR(3 * j.zz, body.inertia.z, 1e-13 * largest);
        EXPECT_LT(std::max({std::abs(j.xy), std::abs(j.xz), std::abs(j.yz)}), 1e-14 * largest);
    }
}

TEST(BodySurface, CountsAVolumeOfSeveralPartsOnce) {
    const BodyShape body = club();
    const DisplacedVolume displaced = displaced_volume(body);
    // The lens of cylinder and ball: the half ball of the stick's end and a cylinder, less what the cap leaves out.
    const double r = 0.3, R = 0.6, depth = std::sqrt(R * R - r * r), cap = R - depth,
                 common = 2.0 / 3 * pi * r * r * r + pi * r * r * depth + pi * cap * cap * (3 * R - cap) / 3;
    EXPECT_NEAR(displaced.volume, body.volume - common, 2e-4 * body.volume);
    EXPECT_LT(trace(displaced.inertia) * 3, body.inertia.x + body.inertia.y + body.inertia.z);
}

TEST(BodySurface, MarkersLieOneDepthWithinIt) {
    constexpr double spacing = 0.1, retraction = 0.04;
    for (const BodyShape& body : {ball(), stick(), block(), club()}) {
        const std::vector<RodMarker> markers = body_markers(body, spacing, retraction);
        Vec3d sum{0, 0, 0};
        for (const RodMarker& m : markers) {
            const Vec3d at{m.off_d1, m.off_d2, m.off_d3};
            double distance = HUGE_VAL;
            for (const BodyShape::Part& part : body.part) distance = std::min(distance, distance_from(part, at));
            EXPECT_NEAR(distance, -retraction, 1e-6 * body.reach); // rings are on polygons of 4096 sides
            EXPECT_EQ(m.along, 0);
            sum += at;
        }
        EXPECT_GT(markers.size(), 100u);
        if (body.part.size() == 1) {
            EXPECT_LT(norm((1.0 / static_cast<double>(markers.size())) * sum - displaced_volume(body).centre), 0.02);
        }
    }
}

TEST(BodySurface, MarkersAreACellApart) {
    constexpr double spacing = 0.1, retraction = 0.04;
    const double radius = 0.7 - retraction;
    EXPECT_NEAR(static_cast<double>(body_markers(ball(), spacing, retraction).size()),
                4 * pi * radius * radius / (spacing * spacing), 1);
    for (const BodyShape& body : {ball(), stick(), block()}) {
        const std::vector<RodMarker> markers = body_markers(body, spacing, retraction);
        for (const RodMarker& a : markers) {
            double nearest = HUGE_VAL;
            for (const RodMarker& b : markers)
                if (&a != &b)
                    nearest =
                        std::min(nearest, norm(Vec3d{a.off_d1 - b.off_d1, a.off_d2 - b.off_d2, a.off_d3 - b.off_d3}));
            EXPECT_GT(nearest, 0.3 * spacing);
            EXPECT_LT(nearest, 1.3 * spacing);
        }
    }
}

TEST(BodySurface, ThinPartsHaveMarkersWithin) {
    const auto places = [](const BodyShape& body) { return body_markers(body, 0.1, 0.04); };
    const auto pebble = places(shape([](BodySpec& b) { b.spheres.radii = {0.03}; }));
    EXPECT_EQ(pebble.size(), 1u);
    EXPECT_EQ(pebble.front().off_d3, 0);
    const auto needle = places(shape([](BodySpec& b) { b.capsules = {{{0, 0, 0}}, {{0, 0, 2}}, {0.02}}; }));
    EXPECT_EQ(needle.size(), 21u);
    const auto card = places(shape([](BodySpec& b) { b.boxes = {{}, {{1.0, 0.6, 0.06}}, {0.01}}; }));
    EXPECT_EQ(card.size(), 9u * 5u);
    const auto splinter = places(shape([](BodySpec& b) { b.boxes = {{}, {{1.0, 0.06, 0.06}}, {0.01}}; }));
    EXPECT_EQ(splinter.size(), 9u);
}

/// A needle of markers on its axis feels no drag about it, so the fluid bears no inertia about it.
TEST(BodySurface, FluidWithinABodyTurnsWhereMarkersTurnIt) {
    RodSpec spec = body_spec();
    BodySpec needle;
    needle.capsules = {{{0, 0, -1}}, {{0, 0, 1}}, {0.02}};
    spec.body = needle;
    spec.shape.length = 2;
    const RodGroup group(spec, 0, 0, ".");
    const InertiaInFluid inertia(group, body_markers(*group.body(), 0.1, 0.04), 1.5, true);
    EXPECT_NEAR(inertia.of_nodes.front().displaced, 0.5, 1e-12);
    EXPECT_NEAR(inertia.of_elements.front().displaced.x, 0.5, 1e-12);
    EXPECT_EQ(inertia.of_elements.front().displaced.z, 0);
    EXPECT_EQ(inertia.of_elements.front().effective.z, 1);
}

} // namespace
} // namespace skein
