// Distances from ellipsoids and rods beside closed forms, and velocities within rods.
#include "immersion/surface.hpp"
#include "immersion/swept_surface.hpp"

#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

namespace skein {
namespace {

TEST(EllipsoidSurface, DistancesAreAlongNormals) {
    std::mt19937 random(3);
    std::normal_distribution<double> any;
    for (const Vec3d& half : {Vec3d{1, 1, 1}, Vec3d{2, 1, 0.7}, Vec3d{0.3, 0.3, 3}, Vec3d{4e-3, 1e-3, 4e-3}}) {
        const EllipsoidSurface surface(half);
        const double least = std::min({half.x, half.y, half.z}), most = std::max({half.x, half.y, half.z}),
                     inner = least * least / most; // the least radius of curvature
        EXPECT_NEAR(surface.distance({0, 0, 0}), -least, 1e-9 * least);
        for (int i = 0; i < 300; ++i) {
            const Vec3d on = scale(half, unit(Vec3d{any(random), any(random), any(random)}));
            const Vec3d normal =
                unit(Vec3d{on.x / (half.x * half.x), on.y / (half.y * half.y), on.z / (half.z * half.z)});
            for (const double s : {-0.95 * inner, -0.1 * inner, 0.0, 0.3 * most, 5 * most})
                EXPECT_NEAR(surface.distance(on + s * normal), s, 1e-12 * most);
        }
        for (const double x : {0.0, 0.2, 0.5}) // on axes, where two points may be nearest
            EXPECT_LT(surface.distance({x * half.x, 0, 0}), 0);
    }
}

/// A rod from the origin along an axis that moves and turns as one body, and gets longer.
struct Straight {
    Vec3d axis, d1, velocity, spin;
    double length, radius, stretching = 0; ///< rate over the length, 1/s
    int elements = 7;

    RodMotion motion() const {
        RodMotion m;
        for (int i = 0; i <= elements; ++i) {
            m.node.push_back((length * i / elements) * axis);
            m.velocity.push_back(velocity + cross(spin, m.node.back()) + stretching * m.node.back());
        }
        m.frame.assign(static_cast<std::size_t>(elements), {d1, cross(axis, d1), axis});
        m.spin.assign(static_cast<std::size_t>(elements), spin);
        return m;
    }
    SweptSurface surface(SweptSection section, double other) const {
        SweptSurface s({section, std::vector<SweptSurface::Element>(static_cast<std::size_t>(elements),
                                                                    {radius, other, length / elements})});
        s.put(motion(), motion());
        return s;
    }
};

Straight slanted() {
    const Vec3d axis = unit(Vec3d{2, -1, 0.5});
    return {axis, directions_across(axis).first, {0.3, 0.1, -0.2}, {0.5, 1, -2}, 1.4, 0.3};
}

TEST(SweptSurface, StraightRodsAreCylindersAndBeamsWithFlatEnds) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(-1, 1);
    const Straight rod = slanted();
    const SweptSurface round = rod.surface(SweptSection::ellipse, rod.radius),
                       beam = rod.surface(SweptSection::rectangle, 0.2);
    const auto of_two = [](double a, double b) {
        return std::hypot(std::max(a, 0.0), std::max(b, 0.0)) + std::min(std::max(a, b), 0.0);
    };
    for (int i = 0; i < 1000; ++i) {
        const double y1 = any(random), y2 = any(random), s = 0.7 + 1.2 * any(random);
        const Vec3d place = y1 * rod.d1 + y2 * cross(rod.axis, rod.d1) + s * rod.axis;
        const double end = std::abs(s - 0.7) - 0.7;
        EXPECT_NEAR(round.nearest(place).distance, of_two(std::hypot(y1, y2) - 0.3, end), 1e-14);
        EXPECT_NEAR(beam.nearest(place).distance, of_two(of_two(std::abs(y1) - 0.3, std::abs(y2) - 0.2), end), 1e-14);
        const Vec3d v = rod.velocity + cross(rod.spin, place);
        EXPECT_LT(norm(round.velocity(round.nearest(place)) - v), 1e-14);
        EXPECT_LT(norm(round.velocity_before(round.nearest(place)) - v), 1e-14);
    }
}

TEST(SweptSurface, RodsThatStretchKeepTheirVolume) {
    Straight rod = slanted();
    rod.stretching = 0.7;
    for (const SweptSection section : {SweptSection::ellipse, SweptSection::rectangle, SweptSection::plate}) {
        const SweptSurface surface = rod.surface(section, 0.2);
        const auto velocity = [&](const Vec3d& at) { return surface.velocity(surface.nearest(at)); };
        constexpr double step = 1e-4;
        for (const double y : {-0.2, 0.05, 0.15}) {
            const Vec3d at = 0.63 * rod.axis + y * rod.d1 + 0.1 * cross(rod.axis, rod.d1);
            double divergence = 0;
            for (const Vec3d& e : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
                divergence += dot(e, velocity(at + step * e) - velocity(at - step * e)) / (2 * step);
            EXPECT_LT(std::abs(divergence), 1e-10);
        }
    }
    // 1.21 times as long
    Straight longer = slanted();
    longer.length *= 1.21;
    SweptSurface thin = slanted().surface(SweptSection::ellipse, 0.3);
    thin.put(longer.motion(), longer.motion());
    EXPECT_NEAR(thin.nearest(0.8 * longer.axis).distance, -0.3 / 1.1, 1e-14);
}

/// Elements around a quarter of a circle.
TEST(SweptSurface, BentRodsAreTubes) {
    constexpr int n = 40;
    constexpr double bend = 2, radius = 0.5;
    RodMotion m;
    for (int i = 0; i <= n; ++i) {
        const double angle = 0.5 * std::numbers::pi * i / n;
        m.node.push_back(bend * Vec3d{std::sin(angle), 1 - std::cos(angle), 0});
        m.velocity.push_back({0, 0, 0});
        if (i == n) break;
        const double middle = 0.5 * std::numbers::pi * (i + 0.5) / n;
        const Vec3d t{std::cos(middle), std::sin(middle), 0};
        m.frame.push_back({cross(t, Vec3d{0, 0, 1}), {0, 0, 1}, t});
        m.spin.push_back({0, 0, 0});
    }
    const double rest = norm(m.node[1]);
    for (const SweptSection section : {SweptSection::ellipse, SweptSection::plate}) {
        SweptSurface tube({section, std::vector<SweptSurface::Element>(n, {radius, radius, rest})});
        tube.put(m, m);
        for (const double angle : {0.3, 0.61, 1.2})
            for (const double away : {-0.9, -0.4, 0.2, 0.45, 0.8}) {
                const Vec3d at = Vec3d{0, bend, 0} + (bend + away) * Vec3d{std::sin(angle), -std::cos(angle), 0};
                EXPECT_NEAR(tube.nearest(at).distance, std::abs(away) - radius, 1e-3) << angle << " " << away;
            }
    }
}

/// The nearest of all elements, each as a rod of its own: a wave, whose elements lie near places from several sides.
/// Distance of a place from a polygon, and the element of it that is nearest.
std::pair<double, std::size_t> from_polygon(const std::vector<Vec3d>& node, const Vec3d& at) {
    std::pair<double, std::size_t> least{HUGE_VAL, 0};
    for (std::size_t k = 0; k + 1 < node.size(); ++k) {
        const Vec3d axis = node[k + 1] - node[k], off = at - node[k];
        const double share = std::clamp(dot(off, axis) / dot(axis, axis), 0.0, 1.0);
        least = std::min(least, {norm(off - share * axis), k});
    }
    return least;
}

TEST(SweptSurface, NoElementIsNearerThanTheOneFound) {
    constexpr int n = 17;
    constexpr double radius = 0.25;
    const auto node = [](int i) { return Vec3d{0.3 * i, 0.8 * std::sin(0.9 * i), 0.2 * std::cos(1.3 * i)}; };
    RodMotion m;
    std::vector<SweptSurface::Element> elements;
    for (int i = 0; i <= n; ++i) {
        m.node.push_back(node(i) - node(0));
        m.velocity.push_back({0, 0, 0});
        if (i == n) break;
        const Vec3d axis = node(i + 1) - node(i), t = (1 / norm(axis)) * axis, across = cross(t, Vec3d{0, 0, 1}),
                    d1 = (1 / norm(across)) * across;
        m.frame.push_back({d1, cross(t, d1), t});
        m.spin.push_back({0, 0, 0});
        elements.push_back({radius, radius, norm(axis)});
    }
    SweptSurface wave({SweptSection::ellipse, elements});
    wave.put(m, m);
    int compared = 0;
    for (int p = 0; p < 400; ++p) {
        const Vec3d at{-0.5 + 0.0153 * p, 1.5 * std::sin(0.37 * p), 0.7 * std::cos(0.51 * p)};
        const auto [least, nearest] = from_polygon(m.node, at);
        const SweptSurface::Foot foot = wave.nearest(at);
        const auto flat = [](std::size_t k) { return k == 0 || k + 1 == n; }; // ends, whose faces may be nearer
        if (flat(foot.element) || flat(nearest)) continue;
        EXPECT_NEAR(norm(foot.off), least, 1e-12) << p;
        ++compared;
    }
    EXPECT_GT(compared, 250);
}

enum class Course {
    open,
    closed, ///< a ring
    endless ///< through the periodic faces of a box across x
};

/// Straight elements along a wave or around a ring, whose frames have d2 as near to z as they can.
RodMotion along_course(Course course, int n) {
    const auto node = [&](int i) {
        const double a = 2 * std::numbers::pi * (i % n) / n;
        if (course == Course::closed) return Vec3d{std::cos(a), std::sin(a), 0.2 * std::cos(3 * a)};
        if (course == Course::endless) return Vec3d{0.3 * i, 0.8 * std::sin(3 * a), 0.2 * std::cos(2 * a)};
        return Vec3d{0.3 * i, 0.8 * std::sin(0.9 * i), 0.2 * std::cos(1.3 * i)};
    };
    RodMotion m;
    for (int i = 0; i <= n; ++i) {
        m.node.push_back(node(i) - node(0));
        m.velocity.push_back({0, 0, 0});
        if (i == n) break;
        const Vec3d t = unit(node(i + 1) - node(i)), d1 = unit(cross(t, Vec3d{0, 0, 1}));
        m.frame.push_back({d1, cross(t, d1), t});
        m.spin.push_back({0, 0, 0});
    }
    return m;
}

/// Rods whose sections turn more and more along them: what leaves on one side comes back within the section.
TEST(SweptSurface, RodsThatBendKeepTheirVolume) {
    constexpr int n = 12;
    constexpr double length = 0.2;
    for (const SweptSection section : {SweptSection::ellipse, SweptSection::rectangle, SweptSection::plate}) {
        RodMotion m;
        for (int i = 0; i <= n; ++i) {
            const double s = length * i;
            m.node.push_back({0, 0, s});
            m.velocity.push_back({0.35 * s * s, section == SweptSection::plate ? 0 : -0.2 * s * s, 0});
            if (i == n) break;
            m.frame.push_back({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
            const double middle = s + 0.5 * length;
            m.spin.push_back({section == SweptSection::plate ? 0 : 0.4 * middle, 0.7 * middle, 0});
        }
        SweptSurface rod({section, std::vector<SweptSurface::Element>(n, {0.4, 0.3, length})});
        rod.put(m, m);
        const auto velocity = [&](const Vec3d& at) { return rod.velocity(rod.nearest(at)); };
        constexpr double step = 1e-5;
        for (const double x : {-0.25, 0.1, 0.3})
            for (const double z : {0.5, 0.55, 1.13, 1.74}) { // the first one in the middle of an element
                const Vec3d at{x, 0.07, z};
                double divergence = 0;
                for (const Vec3d& e : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
                    divergence += dot(e, velocity(at + step * e) - velocity(at - step * e)) / (2 * step);
                EXPECT_LT(std::abs(divergence), 1e-9) << x << " " << z;
                EXPECT_GT(norm(rod.shift(rod.nearest(at))), 1e-3);
            }
        for (const double out : {0.4, 0.5}) // at the surface and beyond it; flat sides slip along themselves
            EXPECT_LT(std::abs(rod.shift(rod.nearest({out, 0, 0.55})).x), 1e-15);
    }
}

/// Sections follow waves of stretch and of bending if elements are longer than the radius, and only if they are.
TEST(SweptSurface, SectionsLeaveOutWavesThatAreShortBesideTheRadius) {
    constexpr int n = 12;
    constexpr double length = 0.2;
    for (const double radius : {0.19, 0.3}) {
        RodMotion m;
        for (int i = 0; i <= n; ++i) {
            const double sign = i % 2 == 0 ? 1 : -1;
            m.node.push_back({0, 0, length * i});
            m.velocity.push_back({0, 0, 0.1 * sign});
            if (i == n) break;
            m.frame.push_back({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
            m.spin.push_back({0, 0.7 * sign, 0});
        }
        SweptSurface rod({SweptSection::ellipse, std::vector<SweptSurface::Element>(n, {radius, radius, length})});
        rod.put(m, m);
        const bool follows = radius < length;
        for (const double z : {0.95, 1.05, 1.13, 1.25}) { // two smoothings reach two elements from each end
            const auto foot = rod.nearest({0.1, 0.05, z});
            EXPECT_EQ(norm(rod.shift(foot)) > 1e-3, follows) << radius << " " << z;
            const double rate = 2 * 0.1 / length * (foot.element % 2 == 0 ? -1 : 1);
            EXPECT_NEAR(rod.velocity(foot).y, follows ? -0.5 * rate * 0.05 : 0, 1e-14) << radius << " " << z;
        }
        EXPECT_LT(norm(rod.axis_velocity(rod.nearest({0.1, 0, 1.1}))), 1e-15); // in the middle of an element
        EXPECT_NEAR(rod.axis_velocity(rod.nearest({0.1, 0, 1.05})).z, -0.05, 1e-15);
    }
}

/// Feet by a search through all elements and through those of cubes, and of how many places a surface is near.
int compare_feet(Course course, SweptSection section) {
    constexpr int n = 24;
    std::mt19937 random(11);
    std::uniform_real_distribution<double> any(-1, 1);
    const bool ring = course == Course::closed;
    const RodMotion m = along_course(course, n);
    std::vector<SweptSurface::Element> elements;
    for (int k = 0; k < n; ++k)
        elements.push_back({0.1 + 0.002 * k, 0.15, norm(m.node[to_index(k) + 1] - m.node[to_index(k)])});
    const int through = course != Course::endless ? -1 : section == SweptSection::plate ? 2 : 0;
    SweptSurface all({.section = section, .elements = elements, .through = through, .closed = ring}),
        near({.section = section, .elements = elements, .through = through, .near = 0.15, .closed = ring});
    all.put(m, m);
    near.put(m, m);
    near.sort();
    int close = 0;
    for (int p = 0; p < 4000; ++p) {
        Vec3d at = m.node[to_index(p % n)] + 0.6 * Vec3d{any(random), any(random), any(random)};
        if (course == Course::endless) at.x += m.node[n].x * (p % 5 - 2); // places in other periods
        const SweptSurface::Foot one = all.nearest(at), other = near.nearest(at);
        EXPECT_EQ(one.element, other.element) << p;
        EXPECT_EQ(one.along, other.along) << p;
        EXPECT_EQ(norm(one.off - other.off), 0) << p;
        EXPECT_EQ(one.distance, other.distance) << p;
        close += one.distance < 0.15;
    }
    return close;
}

TEST(SweptSurface, CubesOfElementsFindTheSameFeet) {
    for (const Course course : {Course::open, Course::closed, Course::endless})
        for (const SweptSection section : {SweptSection::ellipse, SweptSection::rectangle, SweptSection::plate})
            EXPECT_GT(compare_feet(course, section),
                      course == Course::endless && section == SweptSection::plate ? 0 : 400);
}

TEST(SweptSurface, FeetOnPlatesThatLeanAreNearestWithinTheirPlane) {
    constexpr int n = 17;
    RodMotion m;
    std::vector<SweptSurface::Element> elements;
    std::vector<Vec3d> in_plane;
    const auto node = [](int i) { return Vec3d{0.3 * i, 0.5 * std::sin(0.9 * i), 0.25 * std::sin(0.7 * i)}; };
    for (int i = 0; i <= n; ++i) {
        m.node.push_back(node(i) - node(0));
        m.velocity.push_back({0, 0, 0});
        in_plane.push_back({m.node.back().x, m.node.back().y, 0});
        if (i == n) break;
        const Vec3d axis = node(i + 1) - node(i), d2{0, 0, 1}, along = axis - dot(axis, d2) * d2,
                    t = (1 / norm(along)) * along;
        m.frame.push_back({cross(d2, t), d2, t});
        m.spin.push_back({0, 0, 0});
        elements.push_back({0.1, 1.0, norm(axis)});
    }
    SweptSurface plate({SweptSection::plate, elements});
    plate.put(m, m);
    int compared = 0;
    for (int p = 0; p < 400; ++p) {
        const Vec3d at{0.3 + 0.012 * p, 0.9 * std::sin(0.37 * p), 0.5 * std::cos(0.51 * p)};
        const auto [least, nearest] = from_polygon(in_plane, {at.x, at.y, 0});
        const SweptSurface::Foot foot = plate.nearest(at);
        const auto end = [](std::size_t k) { return k == 0 || k + 1 == n; };
        if (end(foot.element) || end(nearest)) continue;
        EXPECT_NEAR(norm(foot.off), least, 1e-12) << p;
        ++compared;
    }
    EXPECT_GT(compared, 250);
}

} // namespace
} // namespace skein
