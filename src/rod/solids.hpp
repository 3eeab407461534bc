// Volume, centre and inertia of spheres, capsules and rounded boxes. theory.md (59a)
#pragma once

#include "core/principal_axes.hpp"

namespace skein {

/// One part of a body by itself.
struct Solid {
    double volume;           ///< m^3
    Vec3d centre;            ///< m
    SymmetricMatrix inertia; ///< per mass about its own centre, m^2
};

Solid solid_sphere(const Vec3d& centre, double r);
Solid solid_capsule(const Vec3d& from, const Vec3d& to, double r);
/// Rounded box along the axes; h: half sides without the rounding, m.
Solid solid_box(const Vec3d& centre, const Vec3d& h, double r);

inline SymmetricMatrix times(double a, const SymmetricMatrix& m) {
    return {a * m.xx, a * m.yy, a * m.zz, a * m.xy, a * m.xz, a * m.yz};
}

/// |d|^2 1 - d d^T, the inertia of a point mass.
inline SymmetricMatrix of_point(const Vec3d& d) {
    return {d.y * d.y + d.z * d.z, d.x * d.x + d.z * d.z, d.x * d.x + d.y * d.y, -d.x * d.y, -d.x * d.z, -d.y * d.z};
}

} // namespace skein
