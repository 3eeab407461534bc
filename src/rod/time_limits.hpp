// The largest stable step of a group, in closed form, by mode.                     theory.md (26)-(29)
// Upper bound of the frequencies of the rest shape (Irons: node mass shared between elements); measured true limit over
// it: 1.0000 to 1.012 for straight uniform rods, up to 1.027 tapered. Walls do not lower it.
#pragma once

#include "skein/rod/rod_group.hpp"

#include <string_view>
#include <vector>

namespace skein {

struct TimeLimit {
    std::string_view mode; ///< of limiting_modes
    double dt;             ///< s
    int element;           ///< where it is smallest
};

/// Of the rods of a file that this rank holds; infinite where it holds none.
LeastLimits least_limits_of_rods(const RodGroup& group);

/// One limit per mode, smallest first. Of rods with sizes of their own the smallest over them all, once they are read.
std::vector<TimeLimit> time_limits(const RodGroup& group);

/// Square of the fastest frequency of element k's modes of shear and turning, 1/s^2, where something besides its cells
/// holds it with `held` [1/s^2] about d1, d2, d3: stiffness over inertia, as in (26).
double eigenvalue_of_element(const RodGroup& group, int k, const Vec3d& held);

/// Smallest j >= 1 for each element by which J1 and J2 lift its shear-rotation limit to `dt` (s). Throws InputError
/// where none does.
std::vector<double> rotary_inertia_for(const RodGroup& group, double dt);

/// Tension limit e_c: at larger dilatation directors may flip; infinity where the law is stable in tension (theory.md
/// (15)).
double tension_limit(const RodGroup& group);

} // namespace skein
