// Eigenvalues and eigenvectors of a symmetric 3x3 matrix by Jacobi's rotations, to round-off.
// Eigen's SelfAdjointEigenSolver is not used: its last bits differ, and with them the digest of `skein check --self`,
// which has a body of spheres, capsules and boxes.
#pragma once

#include "skein/core/vec3.hpp"

namespace skein {

struct SymmetricMatrix {
    double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

    SymmetricMatrix& operator+=(const SymmetricMatrix& o) {
        xx += o.xx;
        yy += o.yy;
        zz += o.zz;
        xy += o.xy;
        xz += o.xz;
        yz += o.yz;
        return *this;
    }
    Vec3d operator*(const Vec3d& a) const {
        return {xx * a.x + xy * a.y + xz * a.z, xy * a.x + yy * a.y + yz * a.z, xz * a.x + yz * a.y + zz * a.z};
    }
};

struct PrincipalAxes {
    Vec3d value;
    Mat3d axes; ///< rows: right-handed eigenvectors, each as near as possible to the axis of its number
};
PrincipalAxes principal_axes(const SymmetricMatrix& a);

} // namespace skein
