// Shares of ranks before there are any: who would own which rods, which ghosts each would need of whom, and how long a
// step would take. The partitioner and the search are those of a run, for any number of ranks, on one core.
#pragma once

#include "parallel/threads.hpp"
#include "plan/plan.hpp"
#include "scene/machine_file.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace skein {

struct RankShare {
    std::int64_t rods = 0, elements = 0;
    std::int64_t pairs = 0; ///< candidates that it works out
    std::int64_t ghost_rods = 0, ghost_elements = 0, ghost_slots = 0;
    std::int64_t neighbours = 0;          ///< ranks that ghosts come from, or go to
    std::int64_t messages = 0, bytes = 0; ///< sent a step
    double memory_bytes = 0;              ///< state, exposure and candidates
    double step_s = 0, exchange_s = 0;    ///< of a step; the part of it that waits for messages
};

struct RankForecast {
    std::vector<RankShare> rank;
    int threads = 1;
    double rods_s = 0, pairs_s = 0; ///< of a step on one thread here, measured: passes, and contacts
    double step_s = 0;              ///< of the slowest rank
    double efficiency = 1;          ///< against one rank with as many threads
};

/// `plan`: for any number of ranks. Steps the scene for about `seconds` to measure what a step costs here.
RankForecast forecast_ranks(const Plan& plan, std::span<const RodGroup> groups, int ranks, const MachineFile& machine,
                            double seconds = 1);

std::string to_text(const RankForecast& forecast);
/// The plan's, with the forecast in it.
std::string to_json(const Plan& plan, const RankForecast& forecast);

} // namespace skein
