// A uniform staggered grid: pressure at the centres of cells, each velocity at the faces that it crosses.
#pragma once

#include "skein/core/index.hpp"
#include "skein/core/vec3.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace skein {

/// Along x, y or z.
inline double component_of(const Vec3d& v, int direction) { return direction == 0 ? v.x : direction == 1 ? v.y : v.z; }

/// Of both faces of a direction.
enum class FluidBoundary {
    periodic,
    free_slip, ///< nothing crosses, no stress along the wall
    no_slip,   ///< walls that rest or move along themselves
    through    ///< in at the lower face, out at the upper one
};
inline constexpr std::string_view fluid_boundary_names[] = {"periodic", "free_slip", "no_slip", "through"};

/// Numbers of cells that transforms are fast for: products of 2, 3, 5 and 7.
constexpr bool is_smooth(std::int64_t n) {
    for (const std::int64_t factor : {2, 3, 5, 7})
        while (n % factor == 0) n /= factor;
    return n == 1;
}
constexpr std::int64_t next_smooth(std::int64_t n) {
    while (!is_smooth(n)) ++n;
    return n;
}

struct FluidGrid {
    std::array<int, 3> cells{1, 1, 1};
    double h = 1;         ///< edge of a cell, m
    Vec3d lower{0, 0, 0}; ///< corner of the box, m
    std::array<FluidBoundary, 3> boundary{};

    std::int64_t count() const { return std::int64_t{cells[0]} * cells[1] * cells[2]; }
    Vec3d upper() const { return lower + h * Vec3d{1.0 * cells[0], 1.0 * cells[1], 1.0 * cells[2]}; }
    /// Not beyond a wall.
    bool holds(const Vec3d& place) const {
        const Vec3d from = place - lower, to = upper() - place;
        return (periodic(0) || std::min(from.x, to.x) >= 0) && (periodic(1) || std::min(from.y, to.y) >= 0) &&
               (periodic(2) || std::min(from.z, to.z) >= 0);
    }
    bool periodic(int direction) const { return nth(boundary, direction) == FluidBoundary::periodic; }
};

/// Planes of cells across z, or coefficients along x, of one rank: from `first`, `count` of them.
struct Slab {
    int first, count;
};
inline Slab slab_of(int planes, int rank, int ranks) {
    const auto until = [&](int r) { return static_cast<int>(std::int64_t{planes} * r / ranks); };
    return {until(rank), until(rank + 1) - until(rank)};
}

/// The rank whose slab a plane is in.
inline int rank_of_plane(int plane, int planes, int ranks) {
    return static_cast<int>((std::int64_t{plane + 1} * ranks - 1) / planes);
}

/// Where the numbers of a field lie: rows along x, from a multiple of a cache line on, with ghosts around.
struct FieldLayout {
    static constexpr int ghosts = 2, before = 8; ///< of a row: room in front of its first cell
    int nx = 0, ny = 0, nz = 0;
    std::ptrdiff_t row = 0, plane = 0;

    FieldLayout() = default;
    FieldLayout(int x, int y, int z)
        : nx(x), ny(y), nz(z), row(before + (x + ghosts + 7) / 8 * 8), plane(row * (y + 2 * ghosts)) {}
    std::size_t size() const { return static_cast<std::size_t>(plane) * static_cast<std::size_t>(nz + 2 * ghosts); }
    /// Of cell (i, j, k), ghosts from -2 on.
    std::ptrdiff_t at(int i, int j, int k) const { return (k + ghosts) * plane + (j + ghosts) * row + before + i; }
};

} // namespace skein
