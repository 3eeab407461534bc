// Selection of the coefficients that couple the slabs of all ranks. theory.md (79a)
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/line_ends.hpp"

#include <array>
#include <cmath>
#include <cstdint>

namespace skein {

/// True if a number beyond a slab of `planes` changes its other end by more than 1e-17 of it. The eigenvalue is that of
/// second differences along x and y for a coefficient.
inline bool couples_slabs(double eigenvalue, int planes) {
    constexpr double reach = 39.1; // -log(1e-17)
    const double cosh = 1 - 0.5 * eigenvalue;
    return planes * std::log(cosh + std::sqrt(cosh * cosh - 1)) < reach;
}

/// Number of coupling coefficients of a pressure.
std::int64_t coupling_coefficients(const FluidGrid& grid, int ranks);

} // namespace skein
