// Contact of a rod with a plane and the published anisotropic friction. Means over an element's nodes take half of the
// end node's force more at the ends; what acts on an element goes to its nodes by halves. p = -r n is the arm of the
// contact point.
//   response   -(f.n) n of the elements that are pressed into the plane (f.n < 0), f all forces so far
//   normal     response - k min(gap - r, 0) n - nu (v.n) n;  nothing where gap - r > surface_tol
//   friction   with R = |response|, the axial direction a (tangent in the plane), the rolling one b = a x n, and the
//   smooth switch
//   s
//              from 0 (slips) to 1 (sticks) between two and one times slip_velocity_tol, in this order, each reading
//              what the one before left:
//     kinetic  -(1 - s_a) mu R (u.a) a,   -(1 - s_b) mu_side R (u.b) b with its couple,   u = unit slip
//     static   -min(|f.a|, s_a mu R) sign(f.a) a,   min(|q|, s_b mu_side R) sign(q) b with its couple,   q = (2 c.a/r -
//     f.b)/3 without slip
// Friction coefficients are (forward, backward, sideways).
#pragma once

#include "rod.hpp"

namespace skein::replay {

struct Plane {
    Vec3d origin, normal; ///< m; unit
};
Plane read_plane(const Entry& entry);

struct PlaneFriction {
    bool has_friction;         ///< kind `rod_plane` has the normal load only
    double stiffness, damping; ///< k, N/m; nu, N s/m
    double surface_tolerance;  ///< m
    double slip_velocity = 0;  ///< m/s
    Vec3d kinetic{}, still{};  ///< forward, backward, sideways
    explicit PlaneFriction(const Entry& entry);
    void add(Rod& rod, const Plane& plane) const;
};

} // namespace skein::replay
