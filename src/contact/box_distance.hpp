// Nearest point of a box to a place, in the box's own axes.                                        theory.md (59d)
//   box |x_i| <= h_i;  c_i = x_i - clamp(x_i, -h_i, h_i);  distance |c|
// Within the box the shortest way leads out, and the distance is below 0.
#pragma once

#include "core/value_of.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

/// From the box's surface to a point.
template <class P> struct PointAtBox {
    Vec3<P> on_box, outwards; ///< nearest point, and a unit vector
    P distance;               ///< below 0 within
};
using BoxPoint = PointAtBox<double>;

/// A number within bounds, of which it may take one.
template <class P> P clamped(const P& x, double low, double high) {
    return value_of(x) < low ? P(low) : high < value_of(x) ? P(high) : x;
}

template <class P> PointAtBox<P> nearest_on_box(const Vec3<P>& x, const Vec3d& half) {
    const P at[3] = {x.x, x.y, x.z};
    const double h[3] = {half.x, half.y, half.z};
    P on[3];
    for (int i = 0; i < 3; ++i) on[i] = clamped(at[i], -h[i], h[i]);
    const Vec3<P> foot{on[0], on[1], on[2]}, apart = x - foot;
    if (const P distance = norm(apart); value_of(distance) > 1e-150) return {foot, (1 / distance) * apart, distance};
    int least = 0;
    for (int i = 1; i < 3; ++i)
        if (h[i] - std::abs(value_of(at[i])) < h[least] - std::abs(value_of(at[least]))) least = i;
    double normal[3] = {0, 0, 0};
    normal[least] = std::copysign(1.0, value_of(at[least]));
    on[least] = normal[least] * h[least];
    return {
        {on[0], on[1], on[2]}, constant<P>({normal[0], normal[1], normal[2]}), normal[least] * at[least] - h[least]};
}
inline BoxPoint nearest_on_box(const Vec3d& x, const Vec3d& half) { return nearest_on_box<double>(x, half); }

/// Vertex by signs as bits.
inline Vec3d box_vertex(const Vec3d& half, unsigned bits) {
    return {bits & 1 ? half.x : -half.x, bits & 2 ? half.y : -half.y, bits & 4 ? half.z : -half.z};
}
/// True of bits that are those of another vertex of a box without extent along some axis.
inline bool repeats_vertex(const Vec3d& half, unsigned bits) {
    return (bits & 1 && half.x == 0) || (bits & 2 && half.y == 0) || (bits & 4 && half.z == 0);
}

} // namespace skein
