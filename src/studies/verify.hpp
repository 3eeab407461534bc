// Comparison of a state that was computed again with the checkpoint that was written of it.
#pragma once

#include "simulation/simulation.hpp"

#include <string>

namespace skein {

/// Difference of the present state to a checkpoint of the same step, which is loaded; empty: none. Throws InputError if
/// the checkpoint belongs to another run. Collective.
std::string difference_to(Simulation& simulation, const std::string& checkpoint);

} // namespace skein
