// Resampling of points along rods: orders of places, lengths and curvatures, and the bound on the deviation.
#include "placement/resampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

namespace skein {
namespace {

using Curve = std::function<Vec3d(double)>; // of a parameter from 0 to 1

Vec3d circle(double u) { return {2 * std::cos(3 * u), 2 * std::sin(3 * u), 0}; }
Vec3d helix(double u) { return {std::cos(5 * u), std::sin(5 * u), 1.5 * u}; }
Vec3d bending(double u) { return {u, 0.3 * std::sin(2 * u * u), 0.2 * u * u * u}; } // of varying curvature

/// Points at unequal distances.
std::vector<Vec3d> points_of(const Curve& curve, int pieces) {
    std::vector<Vec3d> points;
    for (int i = 0; i <= pieces; ++i) {
        const double u = static_cast<double>(i) / pieces;
        points.push_back(curve(u + 0.06 * std::sin(2 * std::numbers::pi * u)));
    }
    return points;
}

struct Rod {
    std::vector<Vec3d> nodes;
    double deviation = 0;
};

Rod resampled(std::span<const Vec3d> points, std::size_t elements) {
    PointCurve curve;
    curve.pass_through(points);
    std::vector<PointCurve::Place> places;
    curve.cut(elements, places);
    Rod rod;
    for (const PointCurve::Place& place : places) rod.nodes.push_back(curve.at(place));
    rod.deviation = curve.deviation(places, rod.nodes);
    return rod;
}

double distance_to_line(const Vec3d& p, std::span<const Vec3d> line) {
    double least = HUGE_VAL;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const Vec3d edge = line[i + 1] - line[i];
        const double share = std::clamp(dot(p - line[i], edge) / dot(edge, edge), 0.0, 1.0);
        least = std::min(least, norm(p - line[i] - share * edge));
    }
    return least;
}

/// Largest distance of densely sampled points of one line from the other, both ways.
double distance_between(std::span<const Vec3d> a, std::span<const Vec3d> b) {
    double largest = 0;
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
        for (std::size_t i = 0; i + 1 < from.size(); ++i)
            for (int k = 0; k <= 20; ++k)
                largest = std::max(largest, distance_to_line(from[i] + 0.05 * k * (from[i + 1] - from[i]), to));
    return largest;
}

double length_of(std::span<const Vec3d> line) {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) sum += norm(line[i + 1] - line[i]);
    return sum;
}

double nearest(const Curve& curve, const Vec3d& p) {
    double best = 0, least = HUGE_VAL;
    for (int i = 0; i <= 2000; ++i)
        if (const double u = i / 2000.0, d = norm(p - curve(u)); d < least) {
            least = d;
            best = u;
        }
    double low = best - 1e-3, high = best + 1e-3;
    for (int round = 0; round < 100; ++round) {
        const double a = low + (high - low) / 3, b = high - (high - low) / 3;
        (norm(p - curve(a)) < norm(p - curve(b)) ? high : low) = norm(p - curve(a)) < norm(p - curve(b)) ? b : a;
    }
    return norm(p - curve(0.5 * (low + high)));
}

/// Largest difference of the rod's curvature from that of a rod whose nodes lie on the curve at the same places.
double curvature_error(std::span<const Vec3d> nodes, std::span<const Vec3d> exact) {
    double largest = 0;
    const auto at = [](std::span<const Vec3d> x, std::size_t i) {
        const Vec3d a = x[i] - x[i - 1], b = x[i + 1] - x[i];
        return (2 / (norm(a) + norm(b))) * cross((1 / norm(a)) * a, (1 / norm(b)) * b);
    };
    for (std::size_t i = 1; i + 1 < nodes.size(); ++i) largest = std::max(largest, norm(at(nodes, i) - at(exact, i)));
    return largest;
}

TEST(Resampling, NodesLieOnTheCurveAtFourthOrder) {
    for (const Curve& curve : {Curve(circle), Curve(helix), Curve(bending)}) {
        double before = 0;
        for (const int pieces : {24, 48, 96, 192}) {
            const Rod rod = resampled(points_of(curve, pieces), static_cast<std::size_t>(pieces) * 3 / 4 + 1);
            double error = 0;
            for (const Vec3d& node : rod.nodes) error = std::max(error, nearest(curve, node));
            if (before > 0) {
                EXPECT_GT(before / error, 12) << pieces;
            } // 16 at fourth order
            before = error;
        }
        EXPECT_LT(before, 1e-8);
    }
}

TEST(Resampling, LengthsAndCurvaturesAreOfSecondOrder) {
    const auto speed = [](const Curve& curve, double u) { return norm(curve(u + 1e-6) - curve(u - 1e-6)) / 2e-6; };
    for (const Curve& curve : {Curve(circle), Curve(helix), Curve(bending)}) {
        std::vector<double> arc = {0}; // along the true curve, by Simpson's rule
        constexpr int fine = 4000;
        for (int i = 0; i < fine; ++i) {
            const double u = static_cast<double>(i) / fine, h = 1.0 / fine;
            arc.push_back(arc.back() + h / 6 * (speed(curve, u) + 4 * speed(curve, u + h / 2) + speed(curve, u + h)));
        }
        double length_before = 0, curvature_before = 0;
        for (const std::size_t elements : {60, 120, 240}) {
            const Rod rod = resampled(points_of(curve, static_cast<int>(elements) + 2), elements);
            std::vector<Vec3d> exact;
            for (std::size_t k = 0; k <= elements; ++k) {
                const double s = arc.back() * static_cast<double>(k) / static_cast<double>(elements);
                const auto at = std::min<std::size_t>(
                    static_cast<std::size_t>(std::upper_bound(arc.begin(), arc.end(), s) - arc.begin()), fine);
                const double share = (s - arc[at - 1]) / (arc[at] - arc[at - 1]);
                exact.push_back(curve((static_cast<double>(at) - 1 + share) / fine));
            }
            const double length = std::abs(length_of(rod.nodes) - arc.back()),
                         curvature = curvature_error(rod.nodes, exact);
            if (length_before > 0) {
                EXPECT_GT(length_before / length, 3.7) << elements;
                EXPECT_GT(curvature_before / curvature, 3.3) << elements;
            }
            length_before = length;
            curvature_before = curvature;
        }
    }
}

TEST(Resampling, TheDeviationBoundsTheDistanceBetweenBothLines) {
    std::mt19937 random(7);
    std::normal_distribution<double> noise;
    for (int trial = 0; trial < 60; ++trial) {
        const Curve curve = trial % 3 == 0 ? Curve(circle) : trial % 3 == 1 ? Curve(helix) : Curve(bending);
        std::vector<Vec3d> points = points_of(curve, 3 + trial % 40);
        const double size = trial < 20 ? 0.0 : 0.002 * trial;
        for (Vec3d& p : points) p += size * Vec3d{noise(random), noise(random), noise(random)};
        for (const std::size_t elements : {2, 5, 16, 60}) {
            const Rod rod = resampled(points, elements);
            const double distance = distance_between(rod.nodes, points);
            EXPECT_GE(rod.deviation * (1 + 1e-12), distance) << trial << " " << elements;
            if (size == 0) {
                EXPECT_LE(rod.deviation, 2 * distance + 1e-15) << trial << " " << elements;
            }
        }
    }
}

TEST(Resampling, WildPointsStayNearTheirLine) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> exponent(-6, 3), any(-1, 1);
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<Vec3d> points = {{0, 0, 0}};
        for (int i = 0; i < 2 + trial % 9; ++i)
            points.push_back(points.back() +
                             std::pow(10, exponent(random)) * Vec3d{any(random), any(random), any(random)});
        PointCurve curve;
        curve.pass_through(points);
        for (std::size_t i = 0; i + 1 < points.size(); ++i) {
            const double h = norm(points[i + 1] - points[i]);
            for (int k = 1; k < 10; ++k) {
                const std::vector<Vec3d> chord = {points[i], points[i + 1]};
                EXPECT_LE(distance_to_line(curve.at({i, 0.1 * k}), chord), (0.5 + 1e-9) * h);
            }
        }
    }
}

TEST(Resampling, FewPointsAndStraightLinesAreExact) {
    const std::vector<Vec3d> two = {{1, 2, 3}, {2, 4, 5}}, uneven = {{0, 0, 0}, {0.1, 0, 0}, {0.7, 0, 0}, {1, 0, 0}};
    const Rod line = resampled(two, 4);
    for (std::size_t k = 0; k < 5; ++k)
        EXPECT_LT(norm(line.nodes[k] - two[0] - 0.25 * static_cast<double>(k) * Vec3d{1, 2, 2}), 1e-13);
    EXPECT_LT(line.deviation, 1e-14);
    const Rod straight = resampled(uneven, 5);
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(straight.nodes[k].x, 0.2 * static_cast<double>(k), 1e-14);
    const std::vector<Vec3d> parabola = {{-1, 1, 0}, {0, 0, 0}, {1, 1, 0}};
    PointCurve curve;
    curve.pass_through(parabola);
    for (const double share : {0.25, 0.5, 0.75}) {
        const Vec3d p = curve.at({1, share});
        EXPECT_NEAR(p.y, p.x * p.x, 1e-14);
    }
}

} // namespace
} // namespace skein
