// Largest stable step of a group, in closed form, by mode. theory.md (26)-(29) It rests on an upper bound of the
// frequencies of the rest shape (Irons: node mass shared between elements). The measured true limit is 1.0000 to 1.012
// times this one for straight uniform rods, up to 1.027 times for tapered ones. Walls do not lower it.
#pragma once

#include "skein/rod/rod_group.hpp"

#include <string_view>
#include <vector>

namespace skein {

struct TimeLimit {
    std::string_view mode; ///< one of limiting_modes
    double dt;             ///< s
    int element;           ///< element with this limit
};

/// Least limits of the rods of a file that this rank holds; infinite where it holds none.
LeastLimits least_limits_of_rods(const RodGroup& group, const Threads* threads = nullptr);

/// Limits by mode, smallest first. In a heterogeneous group each is the smallest over all rods, once they are read.
std::vector<TimeLimit> time_limits(const RodGroup& group);

/// Square of the fastest frequency of shear and rotation of element k, 1/s^2. `held` [1/s^2] about d1, d2, d3 adds to
/// its cells: stiffness over inertia, as in (26).
double eigenvalue_of_element(const RodGroup& group, int k, const Vec3d& held);

/// Smallest j >= 1 for each element by which J1 and J2 lift its shear-rotation limit to `dt` (s). Throws InputError
/// where none does.
std::vector<double> rotary_inertia_for(const RodGroup& group, double dt);

/// Tension limit e_c: directors may flip at larger dilatation. It is infinite where the law is stable in tension.
/// theory.md (15)
double tension_limit(const RodGroup& group);

} // namespace skein
