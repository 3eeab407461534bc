// Moment at a vertex as couples on its two elements, opposite lab vectors, so that no net couple is left. theory.md
// (36a)
//   about lab axes    c_{j-1} -= Q_{j-1} m,   c_j += Q_j m                                                  [N m] body
//   about body axes   the gradient of -p.phi_j, phi_j = log(Q_j Q_{j-1}^T), p in the material:
//                     c_{j-1} -= (1 + Phi/2 + g Phi^2) p,   c_j += (1 - Phi/2 + g Phi^2) p                  [N m] body
// The latter acts as a change of the rest curvature by B^-1 p.
#pragma once

#include "core/rotation.hpp"

namespace skein {

/// Couples of a vertex on the elements before and after it, N m, body components of each.
template <class P> struct VertexCouples { Vec3<P> before{}, after{}; };

/// Couples of the moment p about the material axes of a vertex between two frames.
template <class P>
SKEIN_INLINE VertexCouples<P> about_body_axes(const Quaternion<P>& next, const Quaternion<P>& here, const Vec3<P>& p) {
    const RelativeRotation<P> turn = relative_rotation_and_jacobian(next, here);
    const Vec3<P> a = cross(turn.log, p), half = P(0.5) * a, straight = fma(turn.jacobian, cross(turn.log, a), p);
    return {-(straight + half), straight - half};
}

} // namespace skein
