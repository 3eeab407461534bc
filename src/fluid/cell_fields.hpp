// A flow at the middles of cells, for pictures.
#pragma once

#include "fluid/flow.hpp"

#include <vector>

namespace skein {

/// Of this rank's cells, x fastest.
struct CellFields {
    std::vector<float> velocity, vorticity; ///< [cell][3], m/s and 1/s
    std::vector<float> q;                   ///< half of |rotation|^2 - |strain rate|^2, 1/s^2: positive in vortices
    std::vector<float> pressure;            ///< Pa
};
CellFields cell_fields(const FlowSolver& flow, const Threads& threads);

} // namespace skein
