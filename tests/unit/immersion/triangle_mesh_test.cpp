// Closed meshes: distances beside all triangles, solids beside closed forms, and surfaces that enclose no body.
#include "immersion/triangle_mesh.hpp"

#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "support/meshes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace skein {
namespace {

using test::Mesh;

TriangleMesh made(const Mesh& mesh) {
    return {mesh.points, mesh.triangles, [](std::size_t t) { return "triangle " + std::to_string(t + 1); }};
}

std::string fault_of(const Mesh& mesh) {
    try {
        made(mesh);
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

/// Distance from a triangle by the least of a plane, three lines and three points.
double distance_from(const Vec3d& p, const std::array<Vec3d, 3>& corner) {
    double least = HUGE_VAL;
    const Vec3d n = cross(corner[1] - corner[0], corner[2] - corner[0]);
    bool over = true;
    for (int i = 0; i < 3; ++i) {
        const Vec3d a = nth(corner, i), along = nth(corner, (i + 1) % 3) - a;
        const double share = std::clamp(dot(p - a, along) / dot(along, along), 0.0, 1.0);
        least = std::min(least, norm(p - a - share * along));
        over = over && dot(cross(along, p - a), n) >= 0;
    }
    return over ? std::min(least, std::abs(dot(p - corner[0], n)) / norm(n)) : least;
}

/// Signed distance by all triangles; the sum of the solid angles that they have gives the sign.
double distance_by_all(const TriangleMesh& mesh, const Vec3d& p) {
    double least = HUGE_VAL, angle = 0;
    for (const TriangleMesh::Triangle& t : mesh.triangles()) {
        const std::array<Vec3d, 3> corner{mesh.points()[t[0]], mesh.points()[t[1]], mesh.points()[t[2]]};
        least = std::min(least, distance_from(p, corner));
        const Vec3d a = corner[0] - p, b = corner[1] - p, c = corner[2] - p;
        const double x = norm(a), y = norm(b), z = norm(c);
        angle += 2 * std::atan2(dot(a, cross(b, c)), x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y);
    }
    return angle > 2 * std::numbers::pi ? -least : least;
}

TEST(TriangleMesh, DistancesAreThoseOfTheNearestTriangle) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-1.4, 1.4);
    Mesh hollow = test::ball_mesh(1, 2);
    test::append(hollow, test::turned_round(test::box_mesh({0.5, 0.3, 0.4})));
    for (const Mesh& mesh : {test::box_mesh({0.9, 0.5, 0.7}), test::ball_mesh(1, 3), test::star_mesh(), hollow}) {
        const TriangleMesh surface = made(mesh);
        for (int i = 0; i < 500; ++i) {
            const Vec3d p{any(random), any(random), any(random)};
            EXPECT_NEAR(surface.distance(p), distance_by_all(surface, p), 1e-13);
        }
    }
}

TEST(TriangleMesh, SolidsHaveTheirVolumeCentreAndInertia) {
    const Vec3d half{0.9, 0.5, 0.7}, off{3, -2, 5};
    Mesh mesh = test::box_mesh(half);
    for (Vec3d& p : mesh.points) p += off;
    const Solid found = made(mesh).solid(), box = solid_box(off, half, 0);
    EXPECT_NEAR(found.volume, box.volume, 1e-14 * box.volume);
    EXPECT_LT(norm(found.centre - off), 1e-14 * norm(off));
    for (const Vec3d& e : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
        EXPECT_LT(norm(found.inertia * e - box.inertia * e), 1e-14);
    double last = 1;
    for (const int parts : {2, 3, 4}) { // of order 2
        const double error = 1 - made(test::ball_mesh(1, parts)).solid().volume / (4.0 / 3 * std::numbers::pi);
        EXPECT_GT(error, 0);
        if (parts > 2) {
            EXPECT_NEAR(last / error, 4, 0.2);
        }
        last = error;
    }
    Mesh hollow = test::box_mesh({1, 1, 1});
    test::append(hollow, test::turned_round(test::box_mesh({0.5, 0.5, 0.5})));
    EXPECT_NEAR(made(hollow).solid().volume, 7, 1e-13);
}

TEST(TriangleMesh, PointsInOnePlaceAreOne) {
    Mesh apart; // each triangle has points of its own, as in STL files, and some have no area
    for (const TriangleMesh::Triangle& t : test::box_mesh({1, 1, 1}).triangles) {
        const auto first = static_cast<std::uint32_t>(apart.points.size());
        for (const std::uint32_t p : t) apart.points.push_back(test::box_mesh({1, 1, 1}).points[p]);
        apart.triangles.push_back({first, first + 1, first + 2});
        apart.triangles.push_back({first, first + 1, first + 1});
    }
    const TriangleMesh mesh = made(apart);
    EXPECT_EQ(mesh.points().size(), 8u);
    EXPECT_EQ(mesh.triangles().size(), 12u);
    EXPECT_NEAR(mesh.distance({0.2, 0.1, 0.3}), -0.7, 1e-15);
}

TEST(TriangleMesh, RefusesSurfacesThatEncloseNoBody) {
    const auto starts = [](const std::string& text, const std::string& begin) {
        EXPECT_EQ(text.substr(0, begin.size()), begin) << text;
    };
    const auto has = [](const std::string& text, const std::string& part) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    };
    Mesh open = test::box_mesh({1, 1, 1});
    open.triangles.pop_back();
    has(fault_of(open), "belongs to this triangle alone: close the surface");
    Mesh flipped = test::box_mesh({1, 1, 1});
    std::swap(flipped.triangles[4][0], flipped.triangles[4][1]);
    starts(fault_of(flipped), "triangle 5: the edge from (-1, -1, -1) m");
    has(fault_of(flipped), "has the same direction in the triangle beside it (triangle");
    const std::string round = fault_of(test::turned_round(test::box_mesh({1, 1, 1})));
    starts(round, "triangle 1: the closed surface of this triangle encloses -8 m^3");
    Mesh nested = test::box_mesh({1, 1, 1});
    test::append(nested, test::box_mesh({0.5, 0.5, 0.5}));
    has(fault_of(nested), "encloses 1 m^3 within another one");
    Mesh crossing = test::box_mesh({1, 1, 1}), other = test::ball_mesh(0.7, 1);
    for (Vec3d& p : other.points) p += Vec3d{0.9, 0.1, 0.2};
    test::append(crossing, other);
    has(fault_of(crossing), "goes through another one");
    Mesh broken = test::box_mesh({1, 1, 1});
    broken.points[broken.triangles[3][1]].y = NAN;
    has(fault_of(broken), "coordinates must be finite");
    Mesh twice = test::box_mesh({1, 1, 1}), beside = test::box_mesh({1, 1, 1});
    for (Vec3d& p : beside.points) p += Vec3d{2, 2, 0};
    test::append(twice, beside);
    has(fault_of(twice), "belongs to 4 triangles");
    has(fault_of({}), "0 triangles with an area cannot enclose a body");
}

} // namespace
} // namespace skein
