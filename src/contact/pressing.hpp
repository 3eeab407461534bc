// The force that presses the contacts of an assembly, estimated from its weight and the pressure on it, and the overlap
// and the stiffness that go with a force. theory.md (58a), (58b)
//   mean     f = 3 p V1/(n d), n = z phi/2 contacts per rod and volume (Weber), phi = min(0.6, 5.4 d/L) (Philipse), z =
//   6 largest  f (ln N + 0.577) of N = z/2 contacts per rod, whose forces fall off exponentially
// never below what the heaviest rod weighs, nor above all that there is
#pragma once

#include "contact/contact_law.hpp"
#include "skein/rod/rod_group.hpp"

#include <span>

namespace skein {

struct Pressing {
    double force = 0;    ///< largest of the contacts, N; 0: nothing presses
    bool of_lid = false; ///< by the pressure that is put on; else by weight
};

/// Mean diameter of the elements of a group's rods, m.
double mean_diameter(const RodGroup& group);

/// `gravity`: of each group, m/s^2. `pressure`: that something puts on the assembly, Pa, over `area`, m^2.
Pressing pressing(std::span<const RodGroup> groups, std::span<const Vec3d> gravity, double pressure, double area);

/// Overlap, m, at which a law pushes with a force, N.
double overlap_under(const ContactLaw& law, double force);
/// k of a kind of law that pushes with a force, N, at an overlap, m.
double stiffness_for(ContactNormal normal, double force, double overlap);
/// N; two crossed rods of the radius r, m, and Young's modulus E, Pa, pushed to this overlap, m, as real ones would be.
double own_force(double youngs_modulus, double radius, double overlap);

} // namespace skein
