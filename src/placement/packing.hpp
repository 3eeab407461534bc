// Random sequential placement of straight rods without overlap. A direction is drawn for each rod, then centres until
// the rod is clear of all others. The direction stays for `attempts` centres, so that directions follow their law as
// long as rods find places. Further centres have a direction of their own each, which favours directions that fit: a
// rod that cannot lie may still stand. All ranks draw one stream of random numbers, so that a placement depends on its
// seed and on the rods that are there already. Cost at aspect 31: 1 us for a centre tried. 1536 rods of any direction:
// 0.1 s at 5 % of the volume, 0.5 s at 7 %, 3 s at 8.5 %, which is near the largest reachable; within 10 deg of the
// horizontal 0.4 s at 8.5 %, 6 s at 11 %.
#pragma once

#include "skein/core/quaternion.hpp"
#include "skein/placement/packing_spec.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace skein {

/// Points within `radius` of a straight segment of a rod's axis.
struct Capsule {
    Vec3d start, end;
    double radius;
};

struct PackedRods {
    std::vector<Vec3d> origins;      ///< starts of the axes, along a space-filling curve of the centres, m
    std::vector<Quaterniond> frames; ///< d3 along the rod, d1 horizontal
    double fill = 0;                 ///< volume of the capsules over that of the region
    double top = 0;                  ///< z of the region's upper end, m
};

/// Places rods of this length of axis and this radius, whole capsules inside the region and clear of `occupied`, and
/// adds them to it. Throws InputError, whose text begins with `where`, if they do not fit.
PackedRods pack(const Packing& packing, double length, double radius, std::vector<Capsule>& occupied,
                const std::string& where);

/// True where two axes come closer than `distance`.
bool closer(const Capsule& a, const Capsule& b, double distance);

} // namespace skein
