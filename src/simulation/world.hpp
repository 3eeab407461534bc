// The bodies of a scene with all that acts on them, and the clock that steps them.
//
//   advance    batches of steps up to an event                            the loop
//   step       drift | loads of interactions | forces and kick | end      one screen: World::step
#pragma once

#include "core/timer.hpp"
#include "coupling/interaction.hpp"
#include "kernels/kernels.hpp"
#include "neighbourhood/neighbourhood.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "plan/plan.hpp"
#include "simulation/load_balance.hpp"
#include "simulation/state_copy.hpp"
#include "skein/time/clock.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Synchronisation of steps, threads and ranks; the bits are the same.
enum class Protocol {
    asynchronous, ///< tiles take many steps in a row, ranks meet at events: for rods that do not interact
    synchronous   ///< one step at a time, all threads and ranks meet after it: as interacting rods force
};
inline constexpr std::string_view protocol_names[] = {"asynchronous", "synchronous"};

class World {
public:
    /// Bodies in their start state on the ranks that the partition gives them. Collective.
    World(const Communicator& comm, const Threads& threads, std::vector<RodGroup> groups, Plan plan, Protocol protocol,
          Balance balance);
    /// Some bodies of the scene that feel no others, in this process alone.
    World(const Threads& threads, std::vector<RodGroup> groups, Plan plan, std::span<const LocalRod> sample);

    const Communicator comm;
    const Threads& threads;
    std::vector<RodGroup> groups;
    Plan plan;
    Timers timers;
    Clock clock;

    const Rods& rods() const { return *rods_; }
    Rods& rods() { return *rods_; }
    const Interactions& interactions() const { return interactions_; }
    /// Null where bodies do not interact.
    Neighbourhood* neighbourhood() const { return neighbourhood_.get(); }
    Exposure* exposure() const { return exposure_.get(); }
    const Walls* walls() const { return walls_.get(); }
    LoadBalance& balance() { return balance_; }
    const LoadBalance& balance() const { return balance_; }
    /// Number of the present distribution of bodies over ranks.
    std::int64_t owners() const { return owners_; }
    Protocol protocol() const { return synchronous_ ? Protocol::synchronous : Protocol::asynchronous; }
    std::uint64_t digest() const; ///< collective

    /// Steps up to `until`, to the end of the run by what happens in it, or to a failure of this rank's bodies.
    void advance(std::int64_t until);
    /// Steps that were made before. With `check`, false on all ranks where a body of some rank is invalid after the
    /// last. Collective.
    bool repeat(std::int64_t until, bool check);
    /// Trials: advance() ends within a step, without failure, once this is true between its parts. The step is lost.
    void give_up_when(std::function<bool()> gives_up) { gives_up_ = std::move(gives_up); }
    bool gave_up() const { return gave_up_; }
    /// Parts of steps made so far, those of failed attempts among them; of whole steps one each.
    std::int64_t parts_made() const { return parts_made_; }
    /// Parts that the present step is cut into, or the next one.
    std::int64_t parts_of_step() const;
    /// True where something in the scene has ended the run.
    bool ended() const { return finished(interactions_); }

    /// Reason why bodies of this rank became invalid; empty: they did not.
    const std::string& failure() const { return failure_; }
    /// Reason why they are invalid now.
    std::string reason_of_failure() const;
    /// Body of this rank whose strains left the step least room, in words; empty: none was near its limit.
    const std::string& near_limit() const { return near_limit_; }
    /// Largest share that the step had of its limit, of bodies of this rank without damping.
    double undamped_share() const { return undamped_share_; }

    /// Goes on with the same bodies under other groups and another plan, of the same step. Collective.
    void change(std::vector<RodGroup> other_groups, Plan other_plan);

    /// Rates of local()[i] in an evaluation, to be set in its state.
    using Rates = std::function<void(std::size_t i, std::span<Slot<1>> state)>;
    /// Evaluates contacts and walls at a time, s, for figures, tables and frames; state and memory stay as they are.
    /// Bodies are at rest where they are, or come there by these rates in a step of long_step. Collective.
    void evaluate_at_rest(double time, const Rates& rates = {});
    /// Evaluates them for bodies that have been put where they were solved for, with loads of this time. Collective.
    void show_solution(double time, const Rates& rates = {});
    /// Time of the loads, s, since bodies were put there; none: steps have brought them where they are.
    const std::optional<double>& solved() const { return solved_; }

    /// Copy of this rank's state. Collective where bodies interact.
    std::unique_ptr<StateCopy> copy() const;
    void copy_to(StateCopy& copy) const;
    /// Returns to a copy, with the owners of then. Collective.
    void go_back(const StateCopy& copy);
    /// Bodies with the state of a copy and the present plan.dt; `was`: clock of the copy. Collective.
    void begin_again(const StateCopy& copy, const Clock& was);

private:
    bool step(std::span<const Step> steps, bool check);
    enum class StepEnd { done, failed, stopped };
    /// These steps, or the one step of a clock whose steps are cut into parts. `check`: of whole steps, the last.
    StepEnd make(std::span<const Step> steps, bool check);
    /// One step of the clock in as many parts as it needs. It fails where no number of them does, and is taken back
    /// where the run is to stop. Collective.
    StepEnd step_in_parts(StepControl& control, std::span<const Step> whole);
    /// One step of the clock in parts that bodies go through at their pace. It fails where they are too fast.
    /// Collective.
    StepEnd step_at_pace(PaceControl& pace, bool check);
    using AtStage = std::function<void(const Step&)>;
    /// Drift, loads and kick of stages, with what is due where partners are found again and after each of them. False
    /// where `check` finds an invalid body of this rank after the last. Collective where bodies interact.
    bool go_through(std::span<const Step> stages, bool check, const AtStage& at_rebuild = {},
                    const AtStage& at_end = {});
    /// Ends of a part of a step, the gravest last: a body that went too far for what it touches, bodies too near for a
    /// part of this length, a state or corrections that failed.
    enum class PartEnd : std::int64_t { done, too_fast, too_near, invalid, not_converged, stopped };
    /// Parts of a step, on this rank. Collective where bodies interact.
    PartEnd move(std::span<const Step> steps);
    /// Reason why a part of this length, s, failed on this rank, in words.
    std::string text_of(PartEnd end, double part) const;
    /// Time by which a part of a step takes contacts later than in its middle, s; `rate`: 1/s of the longest part that
    /// they are stable in. theory.md (148)
    double delay_of_contacts(double part, double rate) const;
    /// Keeps bodies and what they do to each other in one of two places, and takes them back.
    void keep(std::size_t place);
    void go_back(std::size_t place);
    /// The step in parts; false on all ranks where it failed on one, or is to stop.
    bool step_in_parts(std::int64_t parts);
    /// The step by time.tolerance.
    StepEnd step_by_error(StepControl& control, Companion& companion);
    /// The companion's step in half as many parts, and then the step.
    bool step_with(Companion& companion, std::int64_t parts);
    /// Largest distance of a node from where these parts of the step would have it; rods stay.
    double difference_from(std::int64_t parts);
    std::span<const Step> next_steps(std::int64_t until);
    /// The next step of the clock that is cut into parts, which interactions have begun; where rods meet a partner, the
    /// last of those up to there. Collective where they do.
    std::span<const Step> next_whole(std::int64_t until);
    /// Notes the first body of this rank that is near the limit of its step.
    void watch_limit();
    /// True in a trial that takes too long.
    bool gives_up() { return gives_up_ && (gave_up_ = gave_up_ || gives_up_()); }
    /// Meeting of all ranks after a batch: false on all as soon as one has failed.
    bool all_ranks_valid();
    void make_bodies(std::span<const LocalRod> owned);
    Surroundings make_rods_of(std::span<const LocalRod> owned);
    /// Sends bodies to the ranks that are to own them, within a step. Collective.
    void move_bodies(const Step& step);

    std::unique_ptr<Rods> rods_;
    std::shared_ptr<Walls> walls_;
    std::shared_ptr<Exposure> exposure_; ///< of own bodies; null where they do not interact
    std::unique_ptr<Neighbourhood> neighbourhood_;
    Interactions interactions_;
    LoadBalance balance_;
    std::int64_t together_ = 1; ///< steps of the clock that are made as one, in parts
    bool always_moves_, synchronous_ = false, coupled_ = false, stopped_ = false, gave_up_ = false;
    std::int64_t owners_ = 0, parts_made_ = 0;
    std::function<bool()> gives_up_;
    std::string failure_, near_limit_;
    std::string obstacle_; ///< to the last step that no number of parts does, in words
    double undamped_share_ = 0;
    std::optional<double> solved_; ///< s
};

} // namespace skein
