// Probes of a fluid: velocity and pressure at single places, as columns of the time series.
#pragma once

#include "fluid/flow.hpp"
#include "skein/core/fields.hpp"

#include <array>
#include <string>
#include <vector>

namespace skein {

/// [[fluid_probe]]
struct FluidProbeSpec {
    std::string name;   ///< of its columns
    Vec3d at{0, 0, 0};  ///< m
    std::string source; ///< file:line of the table, for messages

    static constexpr bool output_only = true;

    void fields(FieldVisitor& f);
};

/// Cell with its share in values at a place.
struct CellShare {
    std::array<int, 3> cell;
    double share;
};

/// Shares of the cells whose middles surround a place, linear along each direction. Within half a cell of a wall they
/// continue the line through the next two middles. Shares of 0 are left out; the sum is 1.
std::vector<CellShare> cell_shares(const FluidGrid& grid, const Vec3d& place);

/// Numbers of velocity [m/s] and pressure [Pa] whose sums over all ranks are the values at a place at the flow's time:
/// shares of this rank's cells.
std::array<std::vector<double>, 4> probe_terms(const FlowSolver& flow, const Vec3d& place);

} // namespace skein
