// Uniform staggered grid: pressure at the centres of cells, each velocity at the faces that it crosses.
#pragma once

#include "skein/core/index.hpp"
#include "skein/core/vec3.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace skein {

/// Component along x, y or z.
inline double component_of(const Vec3d& v, int direction) { return direction == 0 ? v.x : direction == 1 ? v.y : v.z; }

/// Condition at both faces of a direction.
enum class FluidBoundary {
    periodic,
    free_slip, ///< walls without friction
    no_slip,   ///< walls at rest, or moving tangentially
    through    ///< inflow at the lower face, outflow at the upper one
};
inline constexpr std::string_view fluid_boundary_names[] = {"periodic", "free_slip", "no_slip", "through"};

/// True for products of 2, 3, 5 and 7: numbers of cells with fast transforms.
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
    /// True if a place is not beyond a wall.
    bool holds(const Vec3d& place) const {
        const Vec3d from = place - lower, to = upper() - place;
        return (periodic(0) || std::min(from.x, to.x) >= 0) && (periodic(1) || std::min(from.y, to.y) >= 0) &&
               (periodic(2) || std::min(from.z, to.z) >= 0);
    }
    bool periodic(int direction) const { return nth(boundary, direction) == FluidBoundary::periodic; }
};

/// Consecutive planes of cells across z, or coefficients along x, of one rank.
struct Slab {
    int first, count;
};
inline Slab slab_of(int planes, int rank, int ranks) {
    const auto until = [&](int r) { return static_cast<int>(std::int64_t{planes} * r / ranks); };
    return {until(rank), until(rank + 1) - until(rank)};
}

/// Rank whose slab has a plane.
inline int rank_of_plane(int plane, int planes, int ranks) {
    return static_cast<int>((std::int64_t{plane + 1} * ranks - 1) / planes);
}

/// Layout of a field: rows along x that start at cache lines, with ghosts around.
struct FieldLayout {
    static constexpr int ghosts = 2, before = 8; ///< `before`: numbers before the first cell of a row
    int nx = 0, ny = 0, nz = 0;
    std::ptrdiff_t row = 0, plane = 0;

    FieldLayout() = default;
    FieldLayout(int x, int y, int z)
        : nx(x), ny(y), nz(z), row(before + (x + ghosts + 7) / 8 * 8), plane(row * (y + 2 * ghosts)) {}
    std::size_t size() const { return to_index(plane) * to_index(nz + 2 * ghosts); }
    /// Offset of cell (i, j, k); ghosts begin at -2.
    std::ptrdiff_t at(int i, int j, int k) const { return (k + ghosts) * plane + (j + ghosts) * row + before + i; }
};

} // namespace skein
