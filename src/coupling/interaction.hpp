// Anything that bodies do to each other, or that answers what they do, between the two halves of a step.
#pragma once

#include "core/timer.hpp"
#include "coupling/companion.hpp"
#include "coupling/overlap_watch.hpp"
#include "io/checkpoint.hpp"
#include "kernels/kernels.hpp"
#include "neighbourhood/neighbourhood.hpp"
#include "parallel/communicator.hpp"
#include "tiles/rods.hpp"
#include "time/every.hpp"
#include "time/step_control.hpp"

#include <nlohmann/json_fwd.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// The strongest force on a body.
struct Touch {
    double force = 0; ///< N
    std::string text; ///< of what, and how; empty: there is none
};

/// A column of the time series, a number of the whole scene, by what this rank knows of it.
struct Figure {
    enum class Of { sum, total, largest, same };
    std::string name; ///< with its unit
    Of of = Of::sum;
    std::vector<double> terms;             ///< those of a sum, or one number
    double times = 1, over = 1;            ///< of a sum
    std::optional<BinnedTotal> total = {}; ///< of this rank
    bool of_steps = false;                 ///< steps alone make it, so that bodies solved for have no value
};

/// Parts of a run that interactions are made from, which must outlive them.
struct InteractionParts {
    const Communicator& comm;
    const Threads& threads;
    const Plan& plan;
    std::span<const RodGroup> groups;
    const Rods& rods;
    const Surroundings& around;
};

/// Time at which observables are taken.
struct Sample {
    double time = 0, lag = 0; ///< s; positions are `lag` behind the rates
    bool solved = false;      ///< bodies are where they were solved for, with loads of `time`
};

class Interaction {
public:
    virtual ~Interaction() = default;

    /// True if its partners are still all that bodies may have at their present places. This rank alone.
    virtual bool holds() { return true; }
    /// A rebuild of partners, in three calls. First: slots are about to change their numbers; returns the reach, m,
    /// within which elements of others are to be seen. Second: finds partners among all elements near, and marks the
    /// ghosts that it needs. Third: takes the slots from now on, by slot of the search; collective.
    virtual double begin_rebuild() { return 0; }
    virtual void find_partners([[maybe_unused]] const Exposure& near, [[maybe_unused]] std::span<std::uint8_t> wanted) {
    }
    virtual void settle([[maybe_unused]] std::span<const std::uint32_t> slot) {}

    /// This rank owns other bodies from now on, those of `parts`. Called between begin_rebuild and find_partners;
    /// restore() of what was saved() before follows.
    virtual void rebind(const InteractionParts& parts) = 0;
    /// Adds its work in a step to that of own bodies (Rods::local()), in pairs of elements that touch. This rank alone.
    virtual void add_work([[maybe_unused]] std::span<const LocalRod> own,
                          [[maybe_unused]] std::span<double> work) const {}

    /// Before the first of steps that bodies make by themselves: what they are to feel in them. Collective.
    virtual void begin([[maybe_unused]] const Step& first, [[maybe_unused]] Timers& timers) {}
    /// A step that is not one of the run is about to evaluate loads, for figures, tables and frames. Where saved()
    /// gives the memory of before until the next begin(), figures stay; else that memory is restored. Collective.
    virtual void begin_evaluation() {}
    /// Adds loads to those of the slots, when own bodies have exposed themselves: those for which no ghost is needed.
    /// This rank alone.
    virtual void add_own([[maybe_unused]] const Step& step) {}
    /// The rest, when ghosts have arrived. This rank alone.
    virtual void add_shared([[maybe_unused]] const Step& step) {}
    /// Steps of ranks wait for each other because of it.
    virtual bool couples() const { return false; }
    /// First step after `done` whose end it must see: the next drift waits for it. This rank alone.
    virtual std::int64_t next_coupling([[maybe_unused]] std::int64_t done) const { return Every::never; }
    /// The same after begin(): one longer step may take all steps up to there.
    virtual std::int64_t meeting_after([[maybe_unused]] std::int64_t done) const { return Every::never; }
    /// Bodies are back where begin() found them. The same steps follow in more parts.
    virtual void begin_again() {}
    /// Keeps its state in one of two places, and takes it back where a step is repeated in more parts.
    virtual void keep([[maybe_unused]] std::size_t place) {}
    virtual void go_back([[maybe_unused]] std::size_t place) {}
    /// Way of a node in a part of a step beyond which it may pass what it touches, m.
    virtual double way_in_a_part() const { return HUGE_VAL; }
    /// The longest part of a step in which loads that hold for it are stable as bodies are now, s. This rank alone.
    virtual double longest_part() const { return HUGE_VAL; }
    /// The pair of bodies that limits it, in words; empty: none does. This rank alone.
    virtual std::string tightest_pair() const { return {}; }
    /// True if end_step() must see every step, not only those before a coupling.
    virtual bool ends_every_step() const { return false; }
    /// After the kick: answers of walls and fluids. Collective where it couples.
    virtual void end_step([[maybe_unused]] const Step& step, [[maybe_unused]] Timers& timers) {}
    /// Every 64 steps and at events: watches that are too dear for every step. This rank alone.
    virtual void watch([[maybe_unused]] const Step& step) {}

    /// Resets the search for an end of the run, such as rest. Called after restore() as a stage begins.
    virtual void begin_stage() {}

    /// Control of the parts that steps are cut into; null: it cuts none.
    virtual StepControl* step_control() { return nullptr; }
    /// The same by the pace of what moves, and the speed of the fastest node of this rank, m/s.
    virtual PaceControl* pace_control() { return nullptr; }
    virtual double fastest() const { return 0; }
    /// The body with that node, or the wall, in words: "rod 3 moves".
    virtual std::string fastest_body() const { return {}; }
    /// Second run that shows the error of the first; null: there is none.
    virtual Companion* companion() { return nullptr; }

    /// State of an interaction that may end runs. Not collective.
    enum class Ending { never, not_yet, now };
    virtual Ending ending() const { return Ending::never; }
    /// Reason why this rank cannot go on; empty: there is none. Not collective.
    virtual std::string invalid() const { return {}; }
    /// Cause of that failure, and settings KEY=VALUE that prevent it; empty: unknown. Not collective.
    virtual std::string cause() const { return {}; }
    virtual std::vector<std::string> remedies() const { return {}; }
    /// Likely cause of any failure that its remedies prevent; empty: unknown.
    virtual std::string likely_cause() const { return {}; }
    /// Advice that stands in place of a search for the failure's cause; empty: none.
    virtual std::string advice() const { return {}; }
    /// The longest step that it leaves this rank as bodies are now, s. Not collective.
    virtual double step_limit() const { return HUGE_VAL; }
    /// Strongest force of this interaction on a body of this rank. Not collective.
    virtual Touch strongest_touch(std::int64_t gid) const {
        static_cast<void>(gid);
        return Touch{};
    }
    /// Overlaps that it has seen on this rank. Not collective.
    virtual std::span<OverlapWatch> overlaps() { return {}; }
    /// Sums over ranks that figures() shows. Collective.
    virtual void sum_figures() {}
    /// Its columns of the time series. Not collective.
    virtual std::vector<Figure> figures([[maybe_unused]] const Sample& sample) const { return {}; }
    /// Its part of the progress line.
    virtual std::string progress() const { return {}; }
    /// Its part of summary.json. Collective.
    virtual void summarise([[maybe_unused]] nlohmann::ordered_json& summary) const {}
    /// Report on standard output at the end of a run, and warning; empty: none.
    virtual std::string report() const { return {}; }
    virtual std::string final_warning() const { return {}; }
    /// False where the run ends without what it was made for.
    virtual bool fulfilled() const { return true; }

    /// Term of this rank in the digest, of a state beyond that of bodies. Collective.
    virtual std::uint64_t digest() const { return 0; }
    /// Name of its numbers in checkpoints.
    virtual std::string saved_name() const = 0;
    /// Numbers that its next steps depend on, the same on any number of ranks. Collective.
    virtual SavedNumbers saved() const = 0;
    /// Goes on from these, whatever ranks left them. Collective.
    virtual void restore(const SavedNumbers& kept) = 0;
};

using Interactions = std::vector<std::unique_ptr<Interaction>>;

/// A physics of the plan that acts in a run besides its passes.
class StartsInteraction {
public:
    virtual ~StartsInteraction() = default;
    /// Null where there is nothing to do. Collective.
    virtual std::unique_ptr<Interaction> start(const InteractionParts& parts) const = 0;
};

/// The interactions of a plan, in the order in which they add loads. Collective.
Interactions make_interactions(const InteractionParts& parts);

/// Loads that bodies exert on each other, between drift and kick. Ghosts travel meanwhile. `at_rebuild`, if given, may
/// send bodies to other ranks. Collective.
void add_loads(const Interactions& all, Neighbourhood& neighbourhood, const Step& step, Timers& timers,
               const std::function<void()>& at_rebuild = {});

/// Work of all of them in a step on each of these bodies, in pairs of elements.
std::vector<double> work_of(const Interactions& all, std::span<const LocalRod> own);

/// True if some interaction ends the run, and all that do have come to their end.
bool finished(const Interactions& all);
/// False where the run ends without what one of them was made for.
bool fulfilled(const Interactions& all);
/// The reason of the first that cannot go on; empty: there is none.
std::string invalid(const Interactions& all);
/// Its cause, of the first that says one; empty: none does.
std::string cause(const Interactions& all);
std::vector<std::string> remedies(const Interactions& all);
std::string likely_cause(const Interactions& all);
std::string advice(const Interactions& all);
double step_limit(const Interactions& all);
/// True if one of them does.
bool couples(const Interactions& all);
bool ends_every_step(const Interactions& all);
/// Shortest way in a part of any of them, m, and longest part, s.
double way_in_a_part(const Interactions& all);
double longest_part(const Interactions& all);
/// The pair that sets it, and the body that sets fastest(), in words. This rank alone.
std::string tightest_pair(const Interactions& all);
std::string fastest_body(const Interactions& all);
/// Control of the parts of steps, of the first that has one; null: none has.
StepControl* step_control(const Interactions& all);
PaceControl* pace_control(const Interactions& all);
/// Largest of their speeds on this rank, m/s.
double fastest(const Interactions& all);
/// Its companion; null where there is none.
Companion* companion(const Interactions& all);
/// First coupling of any of them.
std::int64_t next_coupling(const Interactions& all, std::int64_t done);
/// First meeting of any of them; the step after `done` where they have none.
std::int64_t meeting_after(const Interactions& all, std::int64_t done);
/// Strongest force on a body, of any interaction and rank. Collective.
Touch strongest_touch(const Communicator& comm, const Interactions& all, std::int64_t gid);

/// Names and values of all columns of the time series; the values are collective.
std::vector<std::string> names_of_figures(const Interactions& all);
std::vector<double> values_of_figures(const Communicator& comm, const Interactions& all, const Sample& sample);

/// True if bodies of this rank overlap by more than the step allows for, and no warning has said so.
bool has_new_overlaps(const Interactions& all);
/// Warning of such overlaps, a line for rods and for each wall, each once. Collective.
std::string new_overlaps(const Communicator& comm, const Interactions& all);
/// Largest overlaps of this run, of contacts, then of each wall, after their soft_until. Collective.
std::vector<LargestOverlap> largest_overlaps(const Communicator& comm, const Interactions& all);

/// Sum of their terms on this rank. Collective.
std::uint64_t digest_of(const Interactions& all);
/// For checkpoints.
std::vector<std::string> saved_names(const Interactions& all);
std::vector<SavedNumbers> saved(const Interactions& all);
void restore(const Interactions& all, std::span<const SavedNumbers> kept);

} // namespace skein
