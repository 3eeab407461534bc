// State of a flow on every rank, to compare its bits.
#pragma once

#include "fluid/whole_planes.hpp"

#include <vector>

namespace skein::test {

/// Rows of all planes, in the order of ranks. Collective.
inline std::vector<double> state_on_all_ranks(const Communicator& comm, FlowSolver& flow) {
    WholeState state(comm, flow);
    std::vector<double> mine;
    for (int k = 0; k < state.planes().count; ++k)
        state.for_rows(k, [&](std::span<double> row) { mine.insert(mine.end(), row.begin(), row.end()); });
    return comm.all_gather(mine);
}

} // namespace skein::test
