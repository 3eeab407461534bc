// Ends of rods that a stage catches where they are.                                                  docs/stages.md
#pragma once

#include "skein/rod/rod_group.hpp"
#include "skein/time/clock.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

/// A rod as a stage begins. Its passes remember their numbers in an order in which caught ends come first.
struct RodAtStage {
    std::int64_t index;
    std::span<const Slot<1>> state;   ///< canonical
    std::span<const double> memory;   ///< of the stage before
    std::vector<double> initial = {}; ///< memory in the new stage as its passes begin
};

/// Memory that a rod has in the new stage. `before`, `group`: of the stages before and after.
std::vector<double> memory_in_stage(const RodSpec& before, const RodGroup& group, RodAtStage rod, const Clock& clock);

} // namespace skein
