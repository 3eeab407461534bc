// Markers: points of the surfaces of bodies, at which these act on a fluid.
#pragma once

#include "skein/core/vec3.hpp"

#include <cstdint>
#include <vector>

namespace skein {

/// Markers of this rank.
struct Markers {
    static constexpr std::uint32_t no_part = 0xffffffff;

    std::vector<Vec3d> place, velocity; ///< m, m/s, lab
    std::vector<std::int64_t> identity; ///< number among markers of all ranks, which orders sums
    std::vector<std::uint32_t> body;
    std::vector<double> share; ///< of the action there, whose rest a sharp surface has; empty: all have all of it
    bool has_parts = false;
    std::vector<std::uint32_t> part; ///< with parts: that whose load is summed alone, or no_part
    std::vector<Vec3d> arm;          ///< with parts: place from the origin of the part, m

    std::size_t count() const { return place.size(); }
    void resize(std::size_t n) {
        place.resize(n);
        velocity.resize(n);
        identity.resize(n);
        body.resize(n);
        if (!has_parts) return;
        part.resize(n, no_part);
        arm.resize(n);
    }
    void clear() {
        place.clear();
        velocity.clear();
        identity.clear();
        body.clear();
        share.clear();
        part.clear();
        arm.clear();
    }
};

/// Places on an ellipse about the origin with half axes a along x and b along y, at equal arcs of about `spacing`.
std::vector<Vec3d> ellipse_markers(double a, double b, double spacing);
/// Places on a sphere about the origin, about one for each square of `spacing`.
std::vector<Vec3d> sphere_markers(double radius, double spacing);
/// Places on a whole number of elliptic rings about z with half axes a and b, from `low` to `high`. Rings and arcs are
/// about `spacing` apart.
std::vector<Vec3d> tube_markers(double a, double b, double low, double high, double spacing);

} // namespace skein
