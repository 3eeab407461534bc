// Nearest point of a box to a place, in the box's own axes.                                        theory.md (59d)
//   box |x_i| <= h_i;  c_i = x_i - clamp(x_i, -h_i, h_i);  distance |c|
// Within the box the shortest way leads out, and the distance is below 0.
#pragma once

#include "skein/core/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

/// From the box's surface to a point.
struct BoxPoint {
    Vec3d on_box, outwards; ///< nearest point, and a unit vector
    double distance;        ///< below 0 within
};

inline BoxPoint nearest_on_box(const Vec3d& x, const Vec3d& half) {
    const double at[3] = {x.x, x.y, x.z}, h[3] = {half.x, half.y, half.z};
    double on[3];
    for (int i = 0; i < 3; ++i) on[i] = std::clamp(at[i], -h[i], h[i]);
    const Vec3d foot{on[0], on[1], on[2]}, apart = x - foot;
    if (const double distance = norm(apart); distance > 1e-150) return {foot, (1 / distance) * apart, distance};
    int least = 0;
    for (int i = 1; i < 3; ++i)
        if (h[i] - std::abs(at[i]) < h[least] - std::abs(at[least])) least = i;
    double normal[3] = {0, 0, 0};
    normal[least] = std::copysign(1.0, at[least]);
    on[least] = normal[least] * h[least];
    return {{on[0], on[1], on[2]}, {normal[0], normal[1], normal[2]}, std::abs(at[least]) - h[least]};
}

/// Vertex by signs as bits.
inline Vec3d box_vertex(const Vec3d& half, unsigned bits) {
    return {bits & 1 ? half.x : -half.x, bits & 2 ? half.y : -half.y, bits & 4 ? half.z : -half.z};
}
/// True of bits that are those of another vertex of a box without extent along some axis.
inline bool repeats_vertex(const Vec3d& half, unsigned bits) {
    return (bits & 1 && half.x == 0) || (bits & 2 && half.y == 0) || (bits & 4 && half.z == 0);
}

} // namespace skein
