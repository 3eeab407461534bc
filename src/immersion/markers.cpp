#include "immersion/markers.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

using std::numbers::pi;

std::vector<Vec3d> ellipse_markers(double a, double b, double spacing) {
    constexpr int fine = 4096; // sides of the polygon that approximates the arc
    const auto at = [&](int i) { return Vec3d{a * std::cos(2 * pi * i / fine), b * std::sin(2 * pi * i / fine), 0}; };
    std::vector<double> arc(fine + 1, 0.0);
    for (int i = 0; i < fine; ++i) nth(arc, i + 1) = nth(arc, i) + norm(at(i + 1) - at(i));
    const int count = std::max(3, static_cast<int>(std::lround(arc.back() / spacing)));
    std::vector<Vec3d> points;
    int i = 0;
    for (int n = 0; n < count; ++n) {
        const double to = arc.back() * (n + 0.5) / count;
        while (nth(arc, i + 1) < to) ++i;
        const double share = (to - nth(arc, i)) / (nth(arc, i + 1) - nth(arc, i));
        points.push_back((1 - share) * at(i) + share * at(i + 1));
    }
    return points;
}

std::vector<Vec3d> sphere_markers(double radius, double spacing) {
    // A spiral whose turns are as far apart as its points (Fibonacci's lattice).
    const int count = std::max(4, static_cast<int>(std::lround(4 * pi * radius * radius / (spacing * spacing))));
    const double turn = pi * (3 - std::sqrt(5.0));
    std::vector<Vec3d> points;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z), angle = turn * i;
        points.push_back(radius * Vec3d{r * std::cos(angle), r * std::sin(angle), z});
    }
    return points;
}

std::vector<Vec3d> tube_markers(double a, double b, double low, double high, double spacing) {
    const int rings = std::max(1, static_cast<int>(std::lround((high - low) / spacing)));
    std::vector<Vec3d> points;
    for (int r = 0; r < rings; ++r)
        for (const Vec3d& at : ellipse_markers(a, b, spacing))
            points.push_back({at.x, at.y, low + (high - low) * (r + 0.5) / rings});
    return points;
}

} // namespace skein
