// Time of the passes of a step, by the layout of rods in tiles.
#pragma once

#include "plan/plan.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

/// Largest number of rods of each group on a rank.
std::vector<std::int64_t> largest_share(const Plan& plan);
/// Time that the passes of a stage take a rank with these numbers of rods on its longest thread, ns.
double stage_ns(const Plan& plan, std::span<const std::int64_t> counts, int threads);

} // namespace skein
