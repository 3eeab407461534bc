// Contact of a rod with a cylinder or a sphere, with Coulomb friction, as published.
//   d    unit vector from the element to the body's axis or centre;  g = r + R - distance
//   F_n  = H(g)/2 (k g d - nu (v.d) d),  v = v_body - v_rod
//   F    = F_n - min(c_v |v_t|, mu |F_n|) v_t/(|v_t| + 1e-14),  v_t = v - (v.d) d
// The rod's element gets -F, the body 2 F at the contact point: a cylinder turns by it, a sphere does not. The segment
// that is searched starts at the element's centre and so reaches half an element too far: a quirk of the published
// program.
#pragma once

#include "rigid_body.hpp"
#include "segments.hpp"

namespace skein::replay {

struct RodBodyContact {
    double stiffness, damping;         ///< k, N/m; nu, N s/m
    double friction, velocity_damping; ///< mu; c_v, N s/m
    explicit RodBodyContact(const Entry& entry);
    void add(Rod& rod, RigidBody& body) const;

private:
    /// F of a pair that is `apart` from the element to the body.
    Vec3d force(const Vec3d& apart, double radii, const Vec3d& velocity) const;
};

} // namespace skein::replay
