// External loads in the plan of a run.
#pragma once

#include "skein/loads/load.hpp"
#include "skein/rod/rod_group.hpp"

#include <span>
#include <string>
#include <vector>

namespace skein {

struct Plan;

struct LoadPlan {
    std::vector<Load> loads;                        ///< of the scene, with their formulas read
    std::vector<std::string> sources;               ///< file and line of each
    std::vector<std::vector<std::size_t>> of_group; ///< numbers of those that act on each group

    /// Fault in the values of loads at the start of the rods of a group that this rank knows; empty: none.
    std::string fault_at_start(const RodGroup& group) const;
};

/// Fault at the start of the rods of files that this rank holds, which plans do not look at; empty: none.
std::string fault_of_read_rods(const Plan& plan, std::span<const RodGroup> groups);

} // namespace skein
