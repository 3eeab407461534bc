// Anything that bodies do to each other, or that answers what they do, between the two halves of a step. A new kind is
// a class here, a struct in scene/program.hpp and a make_interaction.
#pragma once

#include "core/timer.hpp"
#include "io/checkpoint.hpp"
#include "kernels/kernels.hpp"
#include "neighbourhood/neighbourhood.hpp"
#include "parallel/communicator.hpp"
#include "simulation/overlap_watch.hpp"
#include "tiles/rods.hpp"

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

class Interaction {
public:
    virtual ~Interaction() = default;

    /// Whether its partners are still all that bodies may have where they are now. This rank alone.
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
    virtual void follow(const InteractionParts& parts) = 0;
    /// Adds its work in a step to that of own bodies (Rods::local()), in pairs of elements that touch. This rank alone.
    virtual void add_work([[maybe_unused]] std::span<const LocalRod> own,
                          [[maybe_unused]] std::span<double> work) const {}

    /// Before the first of steps that bodies make by themselves: what they are to feel in them. Collective.
    virtual void begin([[maybe_unused]] const Step& first, [[maybe_unused]] Timers& timers) {}
    /// Adds loads to those of the slots, when own bodies have exposed themselves: those for which no ghost is needed.
    /// This rank alone.
    virtual void add_own([[maybe_unused]] const Step& step) {}
    /// The rest, when ghosts have arrived. This rank alone.
    virtual void add_shared([[maybe_unused]] const Step& step) {}
    /// The first step after `done` behind which end_step() looks at where bodies are: the next drift waits for it. This
    /// rank alone.
    virtual std::int64_t next_coupling([[maybe_unused]] std::int64_t done) const {
        return std::numeric_limits<std::int64_t>::max();
    }
    /// Whether end_step() is to see every step, and not only those before a meeting.
    virtual bool ends_every_step() const { return true; }
    /// After the kick: drives what answers the bodies, such as walls with servos. Collective.
    virtual void end_step([[maybe_unused]] const Step& step, [[maybe_unused]] Timers& timers) {}
    /// Every 64 steps and at events: watches that are too dear for every step. This rank alone.
    virtual void watch([[maybe_unused]] const Step& step) {}

    /// Whether it ends runs, and has done so here. Not collective.
    enum class Ending { never, not_yet, now };
    virtual Ending ending() const { return Ending::never; }
    /// Reason why this rank cannot go on; empty: there is none. Not collective.
    virtual std::string invalid() const { return {}; }
    /// Cause of that failure, and settings KEY=VALUE that prevent it; empty: unknown. Not collective.
    virtual std::string cause() const { return {}; }
    virtual std::vector<std::string> remedies() const { return {}; }
    /// The longest step that it leaves this rank as bodies are now, s. Not collective.
    virtual double step_limit() const { return HUGE_VAL; }
    /// What presses a body of this rank most, by this interaction. Not collective.
    virtual Touch strongest_touch(std::int64_t gid) const {
        static_cast<void>(gid);
        return Touch{};
    }
    /// Overlaps that it has seen on this rank. Not collective.
    virtual std::span<OverlapWatch> overlaps() { return {}; }
    /// Its columns of the time series. `lag`: by which positions are behind the rates, s. Not collective.
    virtual std::vector<Figure> figures([[maybe_unused]] double lag) const { return std::vector<Figure>(); }

    /// Of a state beyond that of bodies: what this rank adds to the digest of all. Collective.
    virtual std::uint64_t digest() const { return 0; }
    /// Name of its numbers in checkpoints.
    virtual std::string saved_name() const = 0;
    /// Numbers that its next steps depend on, the same on any number of ranks. Collective.
    virtual SavedNumbers saved() const = 0;
    /// Goes on from these, whatever ranks left them. Collective.
    virtual void restore(const SavedNumbers& kept) = 0;
};

using Interactions = std::vector<std::unique_ptr<Interaction>>;

/// The interactions of a plan, in the order in which they add loads. Collective.
Interactions make_interactions(const InteractionParts& parts);

/// Between the halves of a step: the loads that bodies exert on each other. Ghosts travel meanwhile. `at_rebuild`, if
/// given, is where bodies may go to other ranks. Collective.
void couple(const Interactions& all, Neighbourhood& neighbourhood, const Step& step, Timers& timers,
            const std::function<void()>& at_rebuild = {});

/// Work of all of them in a step on each of these bodies, in pairs of elements.
std::vector<double> work_of(const Interactions& all, std::span<const LocalRod> own);

class ContactInteraction;
/// Contacts among them; null where rods do not feel each other.
ContactInteraction* contacts_of(const Interactions& all);

/// Whether some interaction ends the run, and all that do have come to their end.
bool finished(const Interactions& all);
/// The reason of the first that cannot go on; empty: there is none.
std::string invalid(const Interactions& all);
/// Its cause, of the first that says one; empty: none does.
std::string cause(const Interactions& all);
std::vector<std::string> remedies(const Interactions& all);
double step_limit(const Interactions& all);
/// Whether one of them is to.
bool ends_every_step(const Interactions& all);
/// That of any of them.
std::int64_t next_coupling(const Interactions& all, std::int64_t done);
/// Of all that touch a body what presses it most, on any rank. Collective.
Touch strongest_touch(const Communicator& comm, const Interactions& all, std::int64_t gid);

/// Names and values of all columns of the time series; the values are collective.
std::vector<std::string> names_of_figures(const Interactions& all);
std::vector<double> values_of_figures(const Communicator& comm, const Interactions& all, double lag);

/// Something of this rank overlaps by more than the step allows for, and has not been told of.
bool overlaps_untold(const Interactions& all);
/// What is to be told of that, a line for rods and for each wall, each once. Collective.
std::string tell_of_overlaps(const Communicator& comm, const Interactions& all);
/// Of contacts, then of each wall: the largest overlap of this run, but of times with soft_until to come. Collective.
std::vector<LargestOverlap> largest_overlaps(const Communicator& comm, const Interactions& all);

/// Of all of them, on this rank. Collective.
std::uint64_t digest_of(const Interactions& all);
/// For checkpoints.
std::vector<std::string> saved_names(const Interactions& all);
std::vector<SavedNumbers> saved(const Interactions& all);
void restore(const Interactions& all, std::span<const SavedNumbers> kept);

} // namespace skein
