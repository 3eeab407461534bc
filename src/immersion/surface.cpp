#include "immersion/surface.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// Share of the way from `outside` to `inside` at which a sphere of radius 1 about the origin is entered.
double entry_of_unit_sphere(const Vec3d& outside, const Vec3d& inside) {
    const Vec3d way = inside - outside;
    const double a = dot(way, way), b = -dot(outside, way), c = dot(outside, outside) - 1;
    // The smaller root c/(b + sqrt(b b - a c)) of a s s - 2 b s + c does not cancel, since b > 0 on the way in.
    return std::clamp(c / (b + std::sqrt(std::max(b * b - a * c, 0.0))), 0.0, 1.0);
}

} // namespace

double Surface::crossing(const Vec3d& outside, const Vec3d& inside) const {
    constexpr int halvings = 52;
    double low = 0, high = 1;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (low + high);
        (distance(outside + middle * (inside - outside)) > 0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

double SphereSurface::crossing(const Vec3d& outside, const Vec3d& inside) const {
    return entry_of_unit_sphere((1 / radius_) * outside, (1 / radius_) * inside);
}

TubeSurface::TubeSurface(double a, double b) : a_(a), b_(b), least_(std::min(a, b)) {}

double TubeSurface::distance(const Vec3d& place) const {
    const double x = place.x / a_, y = place.y / b_;
    return least_ * (std::sqrt(x * x + y * y) - 1); // of slope 1 at most
}

double TubeSurface::crossing(const Vec3d& outside, const Vec3d& inside) const {
    const auto scaled = [this](const Vec3d& at) { return Vec3d{at.x / a_, at.y / b_, 0}; };
    return entry_of_unit_sphere(scaled(outside), scaled(inside));
}

} // namespace skein
