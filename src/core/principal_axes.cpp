#include "core/principal_axes.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

PrincipalAxes principal_axes(const SymmetricMatrix& a) {
    double m[3][3] = {{a.xx, a.xy, a.xz}, {a.xy, a.yy, a.yz}, {a.xz, a.yz, a.zz}},
           v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double size = 0;
    for (const auto& row : m)
        for (const double x : row) size = std::max(size, std::abs(x));
    const auto rotate = [&](int p, int q) { // rotates by the smaller of the angles that make m[p][q] zero
        if (std::abs(m[p][q]) <= 1e-15 * size) return;
        const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
        const double t = std::copysign(1, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < 3; ++k) {
            const double kp = m[k][p], kq = m[k][q];
            m[k][p] = c * kp - s * kq;
            m[k][q] = s * kp + c * kq;
        }
        for (int k = 0; k < 3; ++k) {
            const double pk = m[p][k], qk = m[q][k], vp = v[p][k], vq = v[q][k];
            m[p][k] = c * pk - s * qk;
            m[q][k] = s * pk + c * qk;
            v[p][k] = c * vp - s * vq;
            v[q][k] = s * vp + c * vq;
        }
    };
    for (int sweep = 0; sweep < 12; ++sweep) { // convergence is quadratic: 5 sweeps suffice
        rotate(0, 1);
        rotate(0, 2);
        rotate(1, 2);
    }
    return {{m[0][0], m[1][1], m[2][2]},
            {{v[0][0], v[0][1], v[0][2]}, {v[1][0], v[1][1], v[1][2]}, {v[2][0], v[2][1], v[2][2]}}};
}

} // namespace skein
