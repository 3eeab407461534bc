// Ranks, threads and lanes of this run.
#pragma once

#include "parallel/communicator.hpp"
#include "plan/plan.hpp"

namespace skein {

/// Lanes that serve where `asked` are wanted; 0: the most that this processor has.
int lanes_for(int asked);

/// Collective. `threads` 0: the cores that this rank may use; ranks that the launcher left on the same cores share them
/// evenly. `lanes` as for lanes_for, 0 for a plan to choose; those of the oldest processor serve for
/// all.
Machine machine_of(const Communicator& comm, int threads, int lanes, Mapping mapping = Mapping::automatic);

std::string host_name();
/// Ranks that share this one's machine, and its memory, with it itself. Collective.
int ranks_of_this_machine(const Communicator& comm);

} // namespace skein
