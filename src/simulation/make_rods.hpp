// From a plan to rods with their passes: the one place where the scene's run-time choices become template arguments.
#pragma once

#include "parallel/threads.hpp"
#include "rod/rods.hpp"
#include "scene/plan.hpp"

#include <memory>
#include <span>
#include <vector>

namespace skein {

/// Rods at plan.machine.lanes (1, 2, 4 or 8) in their start state. `groups` and `threads` must outlive them.
std::unique_ptr<Rods> make_rods(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned, const Threads& threads);

} // namespace skein
