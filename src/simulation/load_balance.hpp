// Who owns which body, while a run goes on: where bodies that touch gather on some ranks, they are given out anew. A
// body's cost is that of its elements' passes and of its pairs, at rates that all ranks together have measured, so a
// rank on a slow or busy processor keeps as much as the others. Walls and searches count as if all elements had the
// same share in them. What is measured decides who works a body out, and never a number of its state.
#pragma once

#include "core/timer.hpp"
#include "coupling/interaction.hpp"
#include "parallel/communicator.hpp"
#include "partition/partition.hpp"
#include "plan/plan.hpp"

#include <cstdint>
#include <vector>

namespace skein {

/// When bodies may go to other ranks.
enum class Balance {
    automatic, ///< where the time that this saves, over as many steps as the present owners have had, pays for it
    always,    ///< at every rebuild of partners, with costs that are made up: for checks of the program
    never
};

/// Migrations of a run.
struct BalanceFigures {
    std::int64_t migrations = 0, bodies = 0; ///< bodies: those that went to other ranks
    double imbalance = 0;                    ///< cost of the busiest rank over the mean, when last looked at; 0: never
};

class LoadBalance {
public:
    /// Collective.
    LoadBalance(const Communicator& comm, const Plan& plan, Balance when);

    /// The price of a migration before one has been made, s, as this rank sees it.
    void expect(double seconds) { price_ = seconds; }
    /// Measures what a step costs since the last look, and whether other owners would pay. `left`: steps of the run to
    /// come. Collective; called about once a second, it looks less often where looking takes long.
    void update(Timers& timers, const Rods& rods, const Interactions& all, std::int64_t step, std::int64_t left);
    /// True if bodies move at the next rebuild: the same on all ranks.
    bool due() const { return due_; }
    /// New owners of this rank's rods. Collective.
    std::vector<Assignment> assign(std::span<const RodGroup> groups, const Rods& rods, const Interactions& all) const;
    /// They own them from `step` on: it took `seconds` of this rank, and so many bodies moved. Collective.
    void moved(double seconds, std::int64_t bodies, std::int64_t step);
    /// Bodies stay where they are from now on: a failure is looked for.
    void stop() {
        due_ = false;
        when_ = Balance::never;
    }

    const BalanceFigures& figures() const { return figures_; }

private:
    /// Work of this rank's rods in a step, by place in rods.local().
    struct Work {
        std::vector<double> pairs;  ///< of interactions
        std::vector<double> passes; ///< as the plan predicts them, ns
    };
    Work work_of_rods(const Rods& rods, const Interactions& all) const;
    /// Seconds of a step, by place in rods.local().
    std::vector<double> costs(const Work& work) const;
    void decide(const Rods& rods, const Work& work, std::int64_t step, std::int64_t left);
    bool memory_suffices(const Rods& rods) const;

    const Communicator comm_;
    Balance when_;
    bool due_;
    int sharing_ = 1;                           ///< ranks of this machine
    std::vector<double> passes_;                ///< of a rod in a step, ns, predicted; by group
    double pass_rate_ = 0, pair_rate_ = 0;      ///< s per predicted ns of passes, and per pair
    double rods_before_ = 0, pairs_before_ = 0; ///< s, at the last look
    std::int64_t step_before_ = -1;             ///< of the last look; -1: no times to compare with yet
    std::int64_t owned_since_ = -1;             ///< step; -1: not looked yet
    std::int64_t skipped_ = 0, skip_ = 0;       ///< calls of look since the last that did, and how many are to be
    double price_ = 0;                          ///< of a migration, s
    BalanceFigures figures_;
};

} // namespace skein
