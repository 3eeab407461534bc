// Options of a run, as the command line or a calling program gives them.
#pragma once

#include "simulation/load_balance.hpp"
#include "simulation/progress.hpp"
#include "simulation/rewind.hpp"
#include "simulation/world.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace skein {

struct RunOptions {
    std::string out;        ///< directory of results
    bool overwrite = false; ///< put earlier results into a folder of their own and start anew
    std::int64_t steps = 0; ///< stop after this step; 0: the scene's end
    double until = 0;       ///< stop at this time, s; 0: the scene's end
    double walltime = 0;    ///< end with a checkpoint within this many seconds; 0: never
    double began = 0;       ///< wall_seconds() from which these count; 0: the simulation's construction
    Protocol protocol = Protocol::asynchronous;
    bool checkpoint = true; ///< false: none is written, not even at the end; for timing
    bool quiet = false;     ///< no progress line
    ProgressStyle progress = ProgressStyle::automatic;
    std::optional<PlaceAmongRuns> place = {}; ///< among several runs, which have a progress line even if they are quiet
    RewindMode rewind = RewindMode::automatic;
    Balance balance = Balance::automatic;
    std::string from = {}; ///< without `out`: checkpoint to begin with; empty: the scene's start
};

} // namespace skein
