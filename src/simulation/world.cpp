#include "simulation/world.hpp"

#include "core/memory.hpp"
#include "core/stop.hpp"
#include "mechanics/rod_copies.hpp"
#include "partition/partition.hpp"
#include "physics/walls/wall_plan.hpp"
#include "simulation/branch.hpp"
#include "simulation/caught_ends.hpp"
#include "simulation/machine.hpp"
#include "simulation/migration.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "time/every.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace skein {

namespace {

constexpr Every checks{64}; ///< steps at which tiles look for invalid bodies

/// Refuses bodies that do not fit, before any is made: the system may end a process that takes too much without a word.
/// Ranks of one machine take from the same memory. Collective.
void require_memory(const Communicator& comm, const Plan& plan) {
    const auto sharing = static_cast<double>(ranks_of_this_machine(comm));
    const double needed = (plan.state_bytes + plan.frame_bytes) / comm.size(), there = free_memory() / sharing;
    std::string message;
    if (needed > there)
        message =
            fmt::format("the scene needs {:.3g} GB on {}, of which {:.3g} GB are free: {:.3g} GB for {} rods with {} "
                        "elements, the rest for interactions and output; fewer rods, coarser cells of a "
                        "fluid or more machines would do",
                        1e-9 * needed * sharing, host_name(), 1e-9 * there * sharing,
                        1e-9 * plan.rod_bytes / comm.size() * sharing, plan.rods, plan.elements);
    message = comm.first_text(message);
    if (!message.empty()) throw InputError(message);
}

} // namespace

World::World(const Communicator& on, const Threads& by, std::vector<RodGroup> all, Plan of, Protocol protocol,
             Balance balance)
    : comm(on), threads(by), groups(std::move(all)), plan(std::move(of)), clock(plan.dt, 0, plan.integrator),
      balance_(comm, plan, balance), always_moves_(balance == Balance::always) {
    require_memory(comm, plan);
    std::vector<LocalRod> own = partition(comm, groups);
    keep_own_rods(comm, groups, own);
    const double began = wall_seconds();
    make_bodies(own);
    balance_.expect(2 * (wall_seconds() - began)); // to make them anew, and to send them
    coupled_ = couples(interactions_);
    synchronous_ = coupled_ || protocol == Protocol::synchronous;
}

World::World(const Threads& by, std::vector<RodGroup> all, Plan of, std::span<const LocalRod> sample)
    : comm(Communicator::alone()), threads(by), groups(std::move(all)), plan(std::move(of)),
      clock(plan.dt, 0, plan.integrator), balance_(comm, plan, Balance::never), always_moves_(false) {
    make_bodies(sample);
}

void World::change(std::vector<RodGroup> other_groups, Plan other_plan) {
    const std::unique_ptr<StateCopy> state = copy();
    std::vector<RodSpec> before;
    for (const RodGroup& group : groups) before.push_back(group.spec());
    interactions_.clear();
    neighbourhood_.reset();
    exposure_.reset();
    rods_.reset();
    for (std::size_t g = 0; g < groups.size(); ++g) groups[g] = std::move(other_groups[g]); // their addresses are known
    plan = std::move(other_plan);
    if (const auto* now = plan.find<WallPlan>(); now && walls_) *walls_ = Walls(now->walls); // servos are restored
    make_bodies(state->owned());
    for (std::size_t i = 0; i < state->owned().size(); ++i) {
        const LocalRod& rod = state->owned()[i];
        rods_->import_rod(i, state->state(i));
        rods_->set_budget(i, state->budget(i));
        const std::vector<double> memory =
            memory_in_stage(nth(before, rod.group), nth(groups, rod.group),
                            {rod.index, state->state(i), state->memory(i), rods_->memory(i)}, clock);
        if (!memory.empty()) rods_->set_memory(i, memory);
    }
    restore(interactions_, state->saved());
    for (const auto& interaction : interactions_) interaction->begin_stage();
    near_limit_.clear();
    coupled_ = couples(interactions_);
    synchronous_ = coupled_ || synchronous_;
}

void World::make_bodies(std::span<const LocalRod> owned) {
    interactions_.clear();
    neighbourhood_.reset();
    const Surroundings around = make_rods_of(owned);
    exposure_ = around.exposure;
    if (around.exposure) neighbourhood_ = std::make_unique<Neighbourhood>(comm, threads, around.exposure);
    interactions_ = make_interactions({comm, threads, plan, groups, *rods_, around});
}

Surroundings World::make_rods_of(std::span<const LocalRod> owned) {
    rods_.reset();
    Surroundings around{.walls = walls_}; // the state of their servos is restored
    rods_ = make_rods(plan, groups, owned, threads, around);
    walls_ = around.walls;
    return around;
}

void World::move_bodies(const Step& step) {
    const double began = wall_seconds();
    const std::vector<Assignment> assigned = balance_.assign(groups, *rods_, interactions_);
    const std::int64_t moving = Migration::count(comm, assigned);
    if (moving > 0 || always_moves_) {
        const std::vector<SavedNumbers> numbers = saved(interactions_);
        const Migration migration(comm, groups, *rods_, assigned, kernels(plan.machine.lanes).lanes, threads.count());
        const Surroundings around = make_rods_of(migration.owned());
        migration.put_into(*rods_);
        rods_->begin_within(step);
        for (std::size_t i = 0; i < migration.owned().size(); ++i)
            around.exposure->show(i, migration.state(i), nth(groups, migration.owned()[i].group).body());
        exposure_ = around.exposure;
        neighbourhood_->rebind(around.exposure);
        for (const auto& interaction : interactions_)
            interaction->rebind({comm, threads, plan, groups, *rods_, around});
        restore(interactions_, numbers);
        ++owners_;
    }
    const double seconds = wall_seconds() - began;
    timers.move(Phase::search, Phase::balance, seconds);
    balance_.moved(seconds, moving, step.index);
}

std::uint64_t World::digest() const { return comm.sum_wrapping(rods_->digest() + digest_of(interactions_)); }

void World::advance(std::int64_t until) {
    solved_.reset();
    bool going = true;
    while (clock.done() < until && going) {
        StepControl* control = step_control(interactions_);
        PaceControl* pace = pace_control(interactions_);
        const auto steps = control || pace ? next_whole(until) : next_steps(std::min(until, checks.next(clock.done())));
        const Step end = steps.back();
        const bool check = end.index == until || checks.due(end.index) || control;
        const StepEnd ended_as = make(steps, check);
        if (ended_as == StepEnd::stopped) return;
        const bool valid = ended_as == StepEnd::done;
        clock.advance({&end, 1});
        if (check) {
            watch_limit();
            undamped_share_ = std::max(undamped_share_, rods_->undamped_share());
            for (const auto& interaction : interactions_) interaction->watch(end);
        }
        if (!valid) failure_ = reason_of_failure(); // other ranks learn of it when they meet
        if (!valid && pace && failure_.empty())
            failure_ = fmt::format("step {} needs more than {} parts: a node moves at {:.3g} m/s", end.index,
                                   PaceControl::most_parts, fastest(interactions_));
        if (!valid && control && failure_.empty())
            failure_ = fmt::format("step {} in {} parts {}", end.index, StepControl::most_parts, obstacle_);
        going = (synchronous_ ? all_ranks_valid() : failure_.empty()) && !ended();
    }
}

World::StepEnd World::make(std::span<const Step> steps, bool check) {
    if (StepControl* control = step_control(interactions_)) return step_in_parts(*control, steps);
    if (PaceControl* pace = pace_control(interactions_)) return step_at_pace(*pace, check);
    parts_made_ += static_cast<std::int64_t>(steps.size());
    return step(steps, check) ? StepEnd::done : StepEnd::failed;
}

std::int64_t World::parts_of_step() const {
    const PaceControl* pace = pace_control(interactions_);
    const StepControl* control = step_control(interactions_);
    return pace ? pace->parts() : control ? control->parts() : 1;
}

void World::watch_limit() {
    if (!near_limit_.empty()) return;
    near_limit_ = rods_->near_limit();
    if (!near_limit_.empty()) near_limit_ += fmt::format(" at step {}", clock.done());
}

std::span<const Step> World::next_steps(std::int64_t until) {
    const bool one = synchronous_ && !coupled_;
    return clock.next(std::min(until, next_coupling(interactions_, clock.done())), one ? 1 : Clock::largest_batch);
}

std::span<const Step> World::next_whole(std::int64_t until) {
    std::span<const Step> steps = clock.next(clock.done() + 1, 1);
    if (!step_control(interactions_)) return steps;
    for (const auto& interaction : interactions_) interaction->begin(steps.front(), timers);
    return clock.next_whole(std::min(until, meeting_after(interactions_, clock.done())));
}

bool World::step(std::span<const Step> steps, bool check) {
    for (const auto& interaction : interactions_) interaction->begin(steps.front(), timers);
    const auto end_step = [&](const Step& step) {
        for (const auto& interaction : interactions_) interaction->end_step(step, timers);
    };
    const auto move_if_due = [&](const Step& step) {
        if (balance_.due()) move_bodies(step);
    };
    bool valid = true;
    if (neighbourhood_ || ends_every_step(interactions_)) {
        valid = go_through(steps, check, move_if_due, end_step);
    } else { // per tile: all steps, one pass after another
        {
            const auto timing = timers.time(Phase::rods);
            valid = rods_->advance(steps, check);
        }
        end_step(steps.back());
    }
    return valid && (!check || invalid(interactions_).empty());
}

bool World::go_through(std::span<const Step> stages, bool check, const AtStage& at_rebuild, const AtStage& at_end) {
    const auto timed = [&](auto&& work) {
        const auto timing = timers.time(Phase::rods);
        return work();
    };
    bool valid = true;
    timed([&] { rods_->drift(stages.front()); });
    for (std::size_t i = 0; i < stages.size(); ++i) {
        const Step& stage = stages[i];
        if (neighbourhood_ && stage.meets())
            add_loads(interactions_, *neighbourhood_, stage.meeting(), timers, [&] {
                if (at_rebuild) at_rebuild(stage);
            });
        valid = timed([&] {
            if (i + 1 == stages.size()) return rods_->kick(stage, check);
            rods_->kick_and_drift(stage, stages[i + 1]);
            return true;
        });
        if (at_end) at_end(stage);
    }
    return valid;
}

World::PartEnd World::move(std::span<const Step> steps) {
    if (!neighbourhood_) {
        const auto timing = timers.time(Phase::rods);
        return rods_->advance(steps, true) ? PartEnd::done : PartEnd::not_converged;
    }
    std::vector<Step> stages(steps.begin(), steps.end());
    for (Step& stage : stages) stage.ahead += delay_of_contacts(stage.dt, step_control(interactions_)->touching_rate());
    if (!go_through(stages, true)) return PartEnd::not_converged;
    const double part = steps.back().dt;
    if (part > longest_part(interactions_)) return PartEnd::too_near; // it may throw bodies, too
    if (fastest(interactions_) * part > way_in_a_part(interactions_)) return PartEnd::too_fast;
    return invalid(interactions_).empty() ? PartEnd::done : PartEnd::invalid;
}

double World::delay_of_contacts(double part, double rate) const {
    const double share = part * rate;
    return scheme_of(plan.integrator).delay * std::min(1.0, share * share) * part;
}

void World::keep(std::size_t place) {
    rods_->keep(place);
    if (neighbourhood_)
        for (const auto& interaction : interactions_) interaction->keep(place);
}

void World::go_back(std::size_t place) {
    rods_->go_back(place);
    if (neighbourhood_)
        for (const auto& interaction : interactions_) interaction->go_back(place);
}

bool World::step_in_parts(std::int64_t parts) {
    PartEnd own = PartEnd::done, worst = PartEnd::done;
    double length = 0;
    for (std::int64_t part = 0; part < parts && worst == PartEnd::done;) {
        const bool one = neighbourhood_ || gives_up_; // at a time
        const auto steps = clock.next_in_parts(parts, part, one ? 1 : Clock::largest_batch, together_);
        const auto made = static_cast<std::int64_t>(steps.size() / scheme_of(plan.integrator).stages.size());
        part += made;
        parts_made_ += made;
        length = steps.back().dt;
        own = move(steps);
        if (part < parts && ((!coupled_ && stop_requested()) || gives_up()))
            own = PartEnd::stopped; // partners are within a step of theirs
        worst = static_cast<PartEnd>(comm.max(static_cast<std::int64_t>(own)));
    }
    stopped_ = worst == PartEnd::stopped;
    if (worst == PartEnd::done || stopped_) return !stopped_;
    StepControl& control = *step_control(interactions_);
    control.note_obstacle(worst == PartEnd::too_fast   ? StepControl::Obstacle::speed
                          : worst == PartEnd::too_near ? StepControl::Obstacle::contact
                                                       : StepControl::Obstacle::corrections);
    if (!control.can_refine()) obstacle_ = comm.first_text(own == worst ? text_of(worst, length) : std::string());
    return false;
}

std::string World::text_of(PartEnd end, double part) const {
    switch (end) {
    case PartEnd::too_fast:
        return fmt::format("is too long: {} at {:.3g} m/s, and a part may take a node {:.3g} m far, near what it "
                           "touches",
                           fastest_body(interactions_), fastest(interactions_), way_in_a_part(interactions_));
    case PartEnd::too_near:
        return fmt::format("is too long: {}, which allows parts of {:.3g} s, not of {:.3g} s",
                           tightest_pair(interactions_), longest_part(interactions_), part);
    case PartEnd::invalid:
        return fmt::format("fails: {}", invalid(interactions_));
    default:
        return "has corrections that do not converge";
    }
}

World::StepEnd World::step_at_pace(PaceControl& pace, bool check) {
    bool valid = true; // ranks stay together until all parts are made
    for (pace.begin(); !pace.ended(); pace.next()) {
        if (gives_up()) return StepEnd::stopped;
        if (!pace.choose(comm.max(fastest(interactions_)), plan.dt)) return StepEnd::failed;
        ++parts_made_;
        valid = step(clock.next_in_parts(pace.parts(), pace.part(), 1), check) && valid;
    }
    return valid ? StepEnd::done : StepEnd::failed;
}

World::StepEnd World::step_in_parts(StepControl& control, std::span<const Step> whole) {
    const Step end = whole.back();
    stopped_ = false;
    together_ = end.index - clock.done();
    keep(0);
    const std::int64_t least = plan.automatic_dt ? 1 : together_; // a given dt is that of rods
    if (neighbourhood_) {
        const double speed = comm.max(fastest(interactions_)), rate = control.touching_rate(),
                     fewest = plan.dt * std::max(speed / way_in_a_part(interactions_), rate);
        control.at_least(fewest * static_cast<double>(companion(interactions_) ? 2 * together_ : together_ / least));
    }
    const auto done = [&] {
        if (neighbourhood_) control.set_touching_rate(comm.max(1 / longest_part(interactions_)));
        for (const auto& interaction : interactions_) interaction->end_step(end, timers);
        return comm.max(std::int64_t{!invalid(interactions_).empty()}) == 0 ? StepEnd::done : StepEnd::failed;
    };
    if (Companion* companion = skein::companion(interactions_)) {
        const StepEnd ended_as = step_by_error(control, *companion);
        return ended_as == StepEnd::done ? done() : ended_as;
    }
    while (!step_in_parts(least * control.parts())) {
        go_back(0);
        if (stopped_) return StepEnd::stopped;
        if (!control.refine()) return StepEnd::failed;
        for (const auto& interaction : interactions_) interaction->begin_again();
    }
    control.note();
    return done();
}

bool World::step_with(Companion& companion, std::int64_t parts) {
    companion.enter(*rods_);
    const bool valid = step_in_parts(parts / 2);
    companion.leave(*rods_);
    go_back(0);
    return valid && step_in_parts(parts);
}

double World::difference_from(std::int64_t parts) {
    keep(1);
    go_back(0);
    const double apart = step_in_parts(parts) ? comm.max(rods_->farthest_from(1)) : HUGE_VAL;
    go_back(1);
    return apart;
}

World::StepEnd World::step_by_error(StepControl& control, Companion& companion) {
    bool halved = false; // the step in half as many parts is known
    while (true) {
        const std::int64_t parts = control.parts();
        const bool valid = step_with(companion, parts);
        if (valid) {
            const Companion::Apart own = companion.apart(*rods_);
            const double distance = comm.max(own.now), change = comm.max(own.change);
            const bool compares = halved || !control.trusts(change);
            double local = 0;
            if (halved) local = comm.max(rods_->farthest_from(1));
            else if (compares) local = difference_from(parts / 2);
            if (!stopped_ && (!compares || control.allows(local))) {
                if (compares) control.note_compared(local, distance, change);
                else control.note_trusted(distance, change);
                companion.go_on();
                return StepEnd::done;
            }
            keep(1);
        }
        go_back(0);
        if (stopped_) return StepEnd::stopped;
        if (valid) obstacle_ = "still has an error beyond time.tolerance";
        if (valid) control.note_obstacle(StepControl::Obstacle::error);
        halved = valid;
        if (!control.refine()) return StepEnd::failed;
    }
}

bool World::repeat(std::int64_t until, bool check) {
    bool valid = true;
    while (clock.done() < until) {
        const bool in_parts = step_control(interactions_) || pace_control(interactions_);
        const auto steps = in_parts ? next_whole(until) : next_steps(until);
        const Step end = steps.back();
        const bool last = check && end.index == until;
        valid = make(steps, last) == StepEnd::done || !last;
        if (stopped_) break;
        clock.advance({&end, 1});
    }
    return comm.max(static_cast<std::int64_t>(!valid)) == 0;
}

std::string World::reason_of_failure() const {
    try {
        rods_->inspect(clock.done(), plan.dt);
    } catch (const NumericalError& e) {
        return e.what();
    }
    const std::string reason = invalid(interactions_);
    return reason.empty() ? reason : fmt::format("{} at step {}", reason, clock.done());
}

bool World::all_ranks_valid() {
    const auto timing = timers.time(Phase::agree);
    return comm.max(static_cast<std::int64_t>(!failure_.empty())) == 0;
}

std::unique_ptr<StateCopy> World::copy() const {
    auto made = std::make_unique<StateCopy>(groups, *rods_, owners_);
    copy_to(*made);
    return made;
}

void World::copy_to(StateCopy& copy) const { copy.take(*rods_, interactions_, clock.done()); }

void World::go_back(const StateCopy& copy) {
    if (copy.owners() != owners_) {
        copy.put_back_places(groups);
        make_bodies(copy.owned());
        owners_ = copy.owners();
    }
    copy.put_back(*rods_, interactions_);
    clock = Clock(plan.dt, copy.step(), plan.integrator, clock.shift());
}

void World::begin_again(const StateCopy& copy, const Clock& was) {
    const std::vector<LocalRod>& owned = copy.owned();
    if (copy.owners() != owners_) {
        copy.put_back_places(groups);
        owners_ = copy.owners();
    }
    clock = continued(was, plan.dt, plan.integrator);
    make_bodies(owned);
    for (std::size_t i = 0; i < owned.size(); ++i) {
        std::vector<Slot<1>> state(copy.state(i).begin(), copy.state(i).end());
        with_rod(nth(groups, owned[i].group), owned[i].index, [&](const RodGroup& own) {
            synchronise(own, state, was.lag() - clock.lag()); // theory.md (63)
        });
        rods_->import_rod(i, state);
        if (!copy.memory(i).empty()) rods_->set_memory(i, copy.memory(i));
    }
    restore(interactions_, copy.saved());
}

} // namespace skein
