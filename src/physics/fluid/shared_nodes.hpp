// Nodes of rods in a fluid that joints make one.
#pragma once

#include "coupling/interaction.hpp"
#include "immersion/force_balance.hpp"
#include "physics/fluid/fluid_plan.hpp"

#include <vector>

namespace skein {

/// Shared nodes of this rank's rods; a held node takes all loads.
std::vector<SharedNode> shared_nodes(const InteractionParts& parts, const FluidPlan& plan);

} // namespace skein
