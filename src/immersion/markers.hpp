// Points of the surfaces of bodies, through which a fluid feels them.
#pragma once

#include "skein/core/vec3.hpp"

#include <vector>

namespace skein {

/// All of a scene, the same on all ranks, body by body.
struct Markers {
    std::vector<Vec3d> place, velocity; ///< m, m/s, lab
    std::vector<std::size_t> first;     ///< of each body, and behind the last

    std::size_t count() const { return place.size(); }
};

/// Places on a sphere about the origin, of about one for each `spacing` squared.
std::vector<Vec3d> sphere_markers(double radius, double spacing);
/// On rings about z, of half axes a and b, from `low` to `high` along it, a whole number of them; equal arcs, about `spacing`
/// apart.
std::vector<Vec3d> tube_markers(double a, double b, double low, double high, double spacing);

} // namespace skein
