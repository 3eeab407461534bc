#include "immersion/surface.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

double TubeSurface::distance(const Vec3d& place) const {
    const double x = place.x / a_, y = place.y / b_, q = std::sqrt(x * x + y * y);
    if (!(q > 0)) return -std::min(a_, b_);
    return (q - 1) * q / std::sqrt(x * x / (a_ * a_) + y * y / (b_ * b_)); // of second order in the distance
}

Vec3d TubeSurface::extent() const {
    const double most = std::max(a_, b_);
    return turned_ ? Vec3d{most, most, unbounded} : Vec3d{a_, b_, unbounded};
}

double EllipsoidSurface::distance(const Vec3d& place) const {
    // theory.md (151) over the shortest half axis, with s = t + 1: the sum falls from s = 0 on, and is convex.
    const double least = std::min({half_.x, half_.y, half_.z});
    const Vec3d half = (1 / least) * half_,
                more{(half.x - 1) * (half.x + 1), (half.y - 1) * (half.y + 1), (half.z - 1) * (half.z + 1)};
    // In the plane across a shortest axis the nearest point may lie on either side of it.
    constexpr double beside = 1e-12;
    const auto off_plane = [&](double h, double x) { return std::max(std::abs(x) / least, h == 1 ? beside : 0); };
    const Vec3d from{off_plane(half.x, place.x), off_plane(half.y, place.y), off_plane(half.z, place.z)},
        weighted = scale(half, from);
    double low = std::max({weighted.x - more.x, weighted.y - more.y, weighted.z - more.z}), high = norm(weighted),
           s = low;
    const auto over = [&](const Vec3d& a) { return Vec3d{a.x / (s + more.x), a.y / (s + more.y), a.z / (s + more.z)}; };
    for (int i = 0; i < 200; ++i) {
        const Vec3d share = over(weighted);
        const double excess = dot(share, share) - 1;
        (excess > 0 ? low : high) = s;
        double next = s + excess / (2 * dot(share, over(share)));
        if (!(next >= low && next <= high)) next = 0.5 * (low + high);
        const bool found = std::abs(next - s) <= 1e-15 * next;
        s = next;
        if (found) break;
    }
    return least * (s - 1) * norm(over(from));
}

Vec3d EllipsoidSurface::extent() const {
    const double most = std::max({half_.x, half_.y, half_.z});
    return {most, most, most};
}

} // namespace skein
