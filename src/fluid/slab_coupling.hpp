// Which coefficients couple the slabs of all ranks, where columns are solved slab by slab. theory.md (79a)
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/line_ends.hpp"

#include <array>
#include <cmath>
#include <cstdint>

namespace skein {

/// Of a coefficient with this eigenvalue of the second differences along x and y: whether a number beyond a slab of so
/// many planes is felt at its other end, by more than 1e-17 of it.
inline bool couples_slabs(double eigenvalue, int planes) {
    constexpr double felt = 39.1; // -log(1e-17)
    const double cosh = 1 - 0.5 * eigenvalue;
    return planes * std::log(cosh + std::sqrt(cosh * cosh - 1)) < felt;
}

/// Of a pressure, how many do.
std::int64_t coupling_coefficients(const FluidGrid& grid, int ranks);

} // namespace skein
