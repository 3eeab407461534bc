// Who owns which body, while a run goes on: where bodies that touch gather on some ranks, they are given out anew. A body's cost is
// that of its elements' passes and of its pairs, at rates that all ranks together have measured, so a rank on a slow or busy
// processor keeps as much as the others. What is measured decides who works a body out, and never a number of its state.
#pragma once

#include "core/timer.hpp"
#include "parallel/communicator.hpp"
#include "partition/partition.hpp"
#include "scene/plan.hpp"
#include "simulation/interaction.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

/// When bodies may go to other ranks.
enum class Balance {
    automatic, ///< where the time that this saves, over as many steps as the present owners have had, pays for it
    always,    ///< at every rebuild of partners, with costs that are made up: for checks of the program
    never
};

/// What became of it in a run.
struct BalanceFigures {
    std::int64_t migrations = 0, bodies = 0; ///< that went to other ranks
    double imbalance = 0;                    ///< cost of the busiest rank over the mean, when last looked at; 0: never
};

class LoadBalance {
public:
    LoadBalance(const Communicator& comm, const Plan& plan, std::span<const RodGroup> groups, Balance when);

    /// Measures what a step costs since the last look, and whether other owners would pay. `left`: steps of the run to come.
    /// Collective.
    void look(const Timers& timers, const Rods& rods, const Interactions& all, std::int64_t step, std::int64_t left);
    /// Whether bodies are to move at the next rebuild: the same on all ranks.
    bool due() const { return due_; }
    /// New owners of this rank's rods. Collective.
    std::vector<Assignment> assign(const Rods& rods, const Interactions& all) const;
    /// They own them now: it took `seconds` (of this rank), and so many bodies moved. Collective.
    void moved(double seconds, std::int64_t bodies);
    /// Bodies stay where they are from now on: a failure is looked for.
    void stop() { due_ = false, when_ = Balance::never; }

    const BalanceFigures& figures() const { return figures_; }

private:
    /// Seconds of a step, by place in rods.local().
    std::vector<double> costs(const Rods& rods, const Interactions& all) const;

    const Communicator comm_;
    std::span<const RodGroup> groups_;
    Balance when_;
    bool due_;
    std::vector<double> predicted_;             ///< cost of the passes of a rod over others', by group
    double rod_rate_ = 0, pair_rate_ = 0;       ///< s per predicted cost, and per pair, in a step
    double rods_before_ = 0, pairs_before_ = 0; ///< s, at the last look
    std::int64_t step_before_ = -1;             ///< of the last look, or where the present owners began
    std::int64_t owned_since_ = 0;              ///< step
    double price_ = 0;                          ///< of a migration, s
    BalanceFigures figures_;
};

} // namespace skein
