// Points of the surfaces of bodies, through which a fluid feels them.
#pragma once

#include "skein/core/vec3.hpp"

#include <cstdint>
#include <vector>

namespace skein {

/// Those of this rank.
struct Markers {
    std::vector<Vec3d> place, velocity; ///< m, m/s, lab
    std::vector<std::int64_t> identity; ///< of one among those of all ranks: sums are made in its order
    std::vector<std::uint32_t> body;

    std::size_t count() const { return place.size(); }
    void resize(std::size_t n) {
        place.resize(n);
        velocity.resize(n);
        identity.resize(n);
        body.resize(n);
    }
    void clear() {
        place.clear();
        velocity.clear();
        identity.clear();
        body.clear();
    }
};

/// Places on an ellipse of half axes a along x and b along y about the origin, equal arcs apart, about `spacing`.
std::vector<Vec3d> ellipse_markers(double a, double b, double spacing);
/// Places on a sphere about the origin, of about one for each `spacing` squared.
std::vector<Vec3d> sphere_markers(double radius, double spacing);
/// On rings about z, of half axes a and b, from `low` to `high` along it, a whole number of them; equal arcs, about
/// `spacing` apart.
std::vector<Vec3d> tube_markers(double a, double b, double low, double high, double spacing);

} // namespace skein
