// Frames of bodies that tests place by hand.
#pragma once

#include "skein/core/vec3.hpp"

#include <cmath>

namespace skein::test {

inline const Mat3d upright{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/// A vector turned by a rotation vector.
inline Vec3d turned_by(const Vec3d& v, const Vec3d& angle) {
    const double all = norm(angle);
    if (all == 0) return v;
    const Vec3d k = (1 / all) * angle;
    return std::cos(all) * v + std::sin(all) * cross(k, v) + ((1 - std::cos(all)) * dot(k, v)) * k;
}
/// A frame turned by a rotation vector of the lab.
inline Mat3d turned_by(const Mat3d& frame, const Vec3d& angle) {
    return {turned_by(frame.d1, angle), turned_by(frame.d2, angle), turned_by(frame.d3, angle)};
}

} // namespace skein::test
