// Ranks, threads and lanes of this run.
#pragma once

#include "parallel/communicator.hpp"
#include "plan/plan.hpp"

namespace skein {

/// Lanes of the kernels that serve where `asked` are wanted; 0: the most that this processor runs. If it runs none of
/// those that are built, those that it would serve.
int lanes_for(int asked);
/// Lanes of which a plan may choose fewer for few rods, where so many serve; 0: `asked` are wanted, or there are no
/// others.
int lanes_to_choose_from(int asked, int lanes);

/// Collective. `threads` 0: the cores that this rank may use; ranks that the launcher left on the same cores share them
/// evenly. `lanes` as for lanes_for, 0 for a plan to choose; those of the oldest processor serve for
/// all.
Machine machine_of(const Communicator& comm, int threads, int lanes, Mapping mapping = Mapping::automatic);

std::string host_name();
/// Ranks that share this one's machine, and its memory, with it itself. Collective.
int ranks_of_this_machine(const Communicator& comm);

} // namespace skein
