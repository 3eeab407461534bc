#include "simulation/rewind.hpp"

#include "core/share_text.hpp"
#include "core/two_digits.hpp"
#include "io/trajectory.hpp"
#include "mechanics/invalid_state.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "time/every.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace skein {

constexpr std::int64_t nobody = std::numeric_limits<std::int64_t>::max();

/// The invalid rod of lowest number on a rank.
struct InvalidRod {
    std::int64_t gid = nobody;
    std::size_t rod = 0; ///< place in local()
    bool finite = true;
    bool limit = false;     ///< by its step alone
    std::string text, hint; ///< its fault, and a line on its law or none
};

namespace {

constexpr Every searched{64};             ///< steps of a first coarse search
constexpr std::int64_t copy_every = 1024; ///< steps between two copies at least: one costs as much as ten steps at most
constexpr std::int64_t copy_of_fluid_every = 32; ///< steps of a fluid: a copy costs as much as one at most
constexpr double held = 0.9;                     ///< share of a limit that is proposed
constexpr double resolved_share = 0.1;           ///< of an element's length, or rad: what a load may do within a step
constexpr std::int64_t looked_back = 16;         ///< steps before a failure that may have led to it
constexpr std::int64_t tried_beyond = 50;        ///< steps to a failure for each behind it that is tried too
constexpr int most_attempts = 4;                 ///< at a shorter step, each a quarter of the one before
constexpr double trial_seconds = 8;              ///< wall time that they may take in all
constexpr double repeated_seconds = 2;           ///< of a run that a shorter step is tried on from its beginning
constexpr double repeated_bytes = 1 << 24;       ///< of the copy of that beginning
constexpr double shortest_proposed = 1e-4;       ///< of the step of the run
constexpr double telling_seconds = 0.5;          ///< of it, after which their pace is known

/// The worst of the passes, and what it did.
const PassEffect* worst_of(const std::vector<PassEffect>& effects) {
    const PassEffect* worst = nullptr;
    for (const PassEffect& e : effects) {
        if (!e.finite) return &e;
        if (e.share > 0 && (!worst || e.share > worst->share)) worst = &e;
    }
    return worst;
}

/// Effect of the worst pass; numbers that are not finite count more than any other.
double share_of(const std::vector<PassEffect>& effects) {
    const PassEffect* worst = worst_of(effects);
    return !worst ? 0 : worst->finite ? worst->share : std::numeric_limits<double>::max();
}

std::string story_of(const std::vector<PassEffect>& effects) {
    const PassEffect* worst = worst_of(effects);
    if (!worst) return "no load acts";
    if (!worst->finite)
        return fmt::format("after the pass '{}' numbers at {} {} are not finite", worst->pass,
                           worst->turns ? "element" : "node", worst->at);
    std::string text =
        worst->turns
            ? fmt::format("pass '{}': a couple of {:.3g} N m on element {}, {:.3g} rad within a step", worst->pass,
                          worst->load, worst->at, worst->share)
            : fmt::format("pass '{}': a force of {:.3g} N on node {}, {:.3g} of an element's length within a step",
                          worst->pass, worst->load, worst->at, worst->share);
    const PassEffect* next = nullptr;
    for (const PassEffect& e : effects)
        if (&e != worst && e.share > 0 && (!next || e.share > next->share)) next = &e;
    return next ? fmt::format("{} (next: '{}', {:.3g})", text, next->pass, next->share) : text;
}

InvalidRod first_invalid_rod(const World& world) {
    InvalidRod first;
    std::vector<Slot<1>> state;
    const StepWatch watch = step_watch(world.plan);
    for (std::size_t i = 0; i < world.rods().local().size(); ++i) {
        const LocalRod& rod = world.rods().local()[i];
        if (rod.gid >= first.gid) continue;
        const RodGroup& group = nth(world.groups, rod.group);
        state.resize(static_cast<std::size_t>(group.slots()));
        world.rods().export_rod(i, state);
        const std::string name =
            fmt::format("{} {} of '{}', ", group.strained() ? "rod" : "body", rod.index, group.name());
        with_rod(group, rod.index, [&](const RodGroup& own) {
            if (const auto invalid = find_invalid(own, state)) {
                first = {rod.gid,
                         i,
                         invalid->finite,
                         false,
                         name + invalid->reason + tension_hint(own, state),
                         law_hint(own, state)};
            } else if (!own.strained()) {
                if (const std::string text = unresolved_motion(own, state, watch); !text.empty())
                    first = {rod.gid, i, false, false, name + text, ""}; // by loads of this very step
            } else if (const Tightest at = tightest(own, state); watch.stops && watch.share(at.eigenvalue) > 1) {
                first = {rod.gid, i, true, true, name + text_of(at, watch), law_hint(own, state)};
            }
        });
    }
    return first;
}

/// Longest step that bodies of all ranks allow as they are now, s. Collective.
double present_limit(const World& world) {
    double least = HUGE_VAL;
    const StepWatch watch = step_watch(world.plan);
    std::vector<Slot<1>> state;
    for (std::size_t i = 0; i < world.rods().local().size(); ++i) {
        const LocalRod& rod = world.rods().local()[i];
        const RodGroup& group = nth(world.groups, rod.group);
        state.resize(static_cast<std::size_t>(group.slots()));
        world.rods().export_rod(i, state);
        with_rod(group, rod.index, [&](const RodGroup& own) {
            if (own.strained() && !find_invalid(own, state))
                least = std::min(least, watch.limit(tightest(own, state).eigenvalue));
        });
    }
    return world.comm.min(std::min(least, step_limit(world.interactions())));
}

std::string settings_of(const World& world) {
    return world.comm.first_text(fmt::format("{}", fmt::join(remedies(world.interactions()), " --set ")));
}

} // namespace

Rewind::~Rewind() = default;

void Rewind::keep_copy() {
    const Plan& plan = world_.plan;
    if (plan.pseudo_time || mode_ == RewindMode::never || (mode_ == RewindMode::automatic && plan.copy_bytes == 0))
        return;
    const std::int64_t now = world_.clock.done(), events = plan.events_every;
    if (!Every{events}.due(now)) return; // within a step of the fluid
    if (copy_ && now - copy_->step() < std::max(copy_every, plan.has<FluidPlan>() ? copy_of_fluid_every * events : 0))
        return;
    const auto timing = world_.timers.time(Phase::checkpoint);
    if (copy_ && copy_->owners() != world_.owners()) copy_.reset(); // before there is another
    if (copy_) world_.copy_to(*copy_);
    else copy_ = world_.copy();
    const bool first = !std::exchange(was_copied_, true);
    if (first && plan.predicted_s < repeated_seconds && plan.copy_bytes > 0 && plan.copy_bytes < repeated_bytes)
        first_ = std::make_unique<StateCopy>(*copy_);
}

void Rewind::forget() {
    copy_.reset();
    first_.reset();
}

/// The failure on this rank, at the step at which it began.
struct Rewind::Found {
    std::unique_ptr<StateCopy> start; ///< state before it
    std::int64_t good = 0;            ///< step up to which all went well
    bool failed = false;
    InvalidRod mine = {};
    std::int64_t gid = nobody; ///< of the invalid rod on any rank; nobody: contacts alone
    bool here() const { return gid != nobody && mine.gid == gid; }
};

Rewind::Found Rewind::repeat_to_failure() {
    const Communicator& comm = world_.comm;
    const Clock& clock = world_.clock;
    const std::int64_t failed_by = comm.max(world_.failure().empty() ? std::int64_t{0} : clock.done());
    world_.balance().stop();
    world_.go_back(*copy_);
    std::unique_ptr<StateCopy> older, old = std::move(copy_);
    while (world_.repeat(std::min(failed_by, searched.next(clock.done())), true)) {
        if (clock.done() >= failed_by) return {.start = std::move(older ? older : old)};
        older = std::move(old);
        old = world_.copy();
    }
    Found found{.start = nullptr, .good = old->step(), .failed = true};
    found.start = std::move(older ? older : old); // steps before may have led to it
    world_.go_back(*found.start);
    world_.repeat(found.good, false);
    while (world_.repeat(clock.done() + 1, true)) {
    }
    found.mine = first_invalid_rod(world_);
    found.gid = comm.min(found.mine.gid);
    return found;
}

void Rewind::show_failure(Failure& failure, const std::function<void()>& show) const {
    const Clock& clock = world_.clock;
    try {
        write_single_frame(world_.comm, directory_, "failure", world_.groups, world_.rods(), world_.plan.title,
                           failure.step, clock.time(), clock.lag());
        failure.frame =
            fmt::format("all rods at step {}: {}/failure.h5, for ParaView failure.xdmf", failure.step, directory_);
        show();
    } catch (const IoError& error) { // the run ends with the failure
        if (failure.frame.empty()) failure.frame = fmt::format("failure.h5 was not written: {}", error.what());
    }
}

Failure Rewind::find(const std::function<void()>& show) {
    const Communicator& comm = world_.comm;
    const Plan& plan = world_.plan;
    Failure failure{.text = comm.first_text(world_.failure()),
                    .cause = comm.first_text(cause(world_.interactions())),
                    .settings = settings_of(world_)};
    if (!failure.settings.empty()) failure.likely = likely_cause(world_.interactions());
    const std::string likely = failure.likely, cure = likely.empty() ? "" : failure.settings;
    if (!copy_) return failure;
    const auto timing = world_.timers.time(Phase::rods);
    const Found found = repeat_to_failure();
    if (!found.failed) {
        failure.cause.clear();
        failure.text += fmt::format(
            "\n  the same steps, made again from step {}, went well: suspect this machine, and not the scene",
            found.start->step());
        return failure;
    }
    failure = {.text = {}, .settings = cure, .likely = likely, .step = world_.clock.done()};
    const auto on_all = [&](bool mine) { return comm.max(static_cast<std::int64_t>(found.here() && mine)) != 0; };
    if (found.gid == nobody) {
        failure.text = comm.first_text(world_.reason_of_failure());
        failure.cause = comm.first_text(cause(world_.interactions()));
    } else {
        failure.text =
            comm.first_text(found.here() ? fmt::format("{} at step {} (t = {:.6g} s, dt = {:.6g} s){}", found.mine.text,
                                                       failure.step, world_.clock.time(), plan.dt, found.mine.hint)
                                         : std::string());
    }
    show_failure(failure, show);
    double limit = found.gid == nobody || on_all(found.mine.limit) ? present_limit(world_) : HUGE_VAL;
    if (found.gid != nobody) trace(failure, found, limit);
    if (plan.events_every == 1) { // a fluid starts from ends of its own steps alone
        const std::int64_t last = failure.step + std::max(searched.steps, failure.step / tried_beyond);
        const double beyond = world_.clock.shift() + static_cast<double>(last) * plan.dt;
        try_shorter_steps(failure, *found.start, beyond,
                          rounded_down(std::clamp(held * limit, 0.1 * shortest_proposed * plan.dt, 0.5 * plan.dt)));
    }
    if (!failure.cause.empty() && likely.empty()) failure.settings = settings_of(world_);
    return failure;
}

void Rewind::trace(Failure& failure, const Found& found, double& limit) {
    const Communicator& comm = world_.comm;
    // A shape that is out of bounds has come from the loads of the steps before.
    const bool shape = comm.max(static_cast<std::int64_t>(found.here() && found.mine.finite)) != 0;
    const std::int64_t begin = found.start->step(), last = std::max(begin + 1, failure.step - shape),
                       first = std::max(begin, last - looked_back);
    std::vector<PassEffect> worst;
    Touch touch;
    std::int64_t began = last, touched = last;
    world_.go_back(*found.start);
    world_.repeat(first, false);
    for (std::int64_t step = first + 1; step <= last; ++step) {
        const auto before = world_.copy();
        if (step == last) limit = std::min(limit, present_limit(world_));
        world_.repeat(step, false); // contacts become those of this step
        if (!world_.interactions().empty())
            if (const Touch now = strongest_touch(comm, world_.interactions(), found.gid); now.force > touch.force) {
                touch = now;
                touched = step;
            }
        world_.go_back(*before);
        if (found.here()) {
            auto effects = world_.rods().dissect(found.mine.rod, world_.clock.next(step, 1));
            if (worst.empty() || share_of(effects) > share_of(worst)) {
                worst = std::move(effects);
                began = step;
            }
        }
        world_.go_back(*before);
        world_.repeat(step, false);
    }
    failure.text += comm.first_text(
        found.here() ? fmt::format("\n  where it began: step {}, {}", began, story_of(worst)) : std::string());
    if (!touch.text.empty()) failure.text += fmt::format("\n  touched: at step {} {}", touched, touch.text);
    const double share = comm.max(found.here() ? share_of(worst) : 0);
    if (share > resolved_share) limit = std::min(limit, world_.plan.dt * std::sqrt(resolved_share / share) / held);
}

/// From a copy to a time beyond the failure with a step of `dt`, and ever shorter ones until one holds.
void Rewind::try_shorter_steps(Failure& failure, const StateCopy& start, double until, double dt) {
    const double began = wall_seconds(), dt_of_run = world_.plan.dt, shift = world_.clock.shift();
    enum class Trial { held, failed, too_long };
    const auto tried = [&](const StateCopy& from, double step) {
        world_.plan.dt = step;
        world_.begin_again(from, Clock(dt_of_run, from.step(), world_.plan.integrator, shift));
        const Clock& clock = world_.clock;
        const double first = static_cast<double>(clock.done()), trial_began = wall_seconds();
        for (const std::int64_t end = clock.step_at(until); clock.done() < end;) {
            if (!world_.repeat(std::min(end, clock.done() + searched.steps), true)) return Trial::failed;
            const double now = wall_seconds(), taken = world_.comm.max(now - trial_began);
            const double share = (static_cast<double>(clock.done()) - first) / (static_cast<double>(end) - first);
            const bool hopeless = taken > telling_seconds && taken > share * trial_seconds;
            if (hopeless || world_.comm.max(now - began) > trial_seconds) return Trial::too_long;
        }
        return Trial::held;
    };
    for (int attempt = 0; attempt < most_attempts; ++attempt, dt = rounded_down(dt / 4)) {
        failure.dt = dt;
        Trial trial = tried(start, dt);
        // A step that holds by chance, as for rods that fold, fails with half of it or from the beginning.
        if (trial == Trial::held && tried(start, rounded_down(dt / 2)) == Trial::failed) trial = Trial::failed;
        if (trial == Trial::held && first_ && tried(*first_, dt) == Trial::failed) trial = Trial::failed;
        if (trial == Trial::failed) continue;
        failure.remedy = trial == Trial::held ? Failure::Remedy::step : Failure::Remedy::untried;
        world_.plan.dt = dt_of_run;
        return;
    }
    world_.plan.dt = dt_of_run;
    failure.remedy = Failure::Remedy::none;
}

std::string text_of(const Failure& failure, const Plan& plan, std::int64_t last_checkpoint,
                    const std::string& directory) {
    using Remedy = Failure::Remedy;
    const double dt = plan.dt, ratio = dt / plan.limit;
    // A step so short that no run would end is no remedy.
    const bool too_short = failure.remedy == Remedy::untried && failure.dt < shortest_proposed * dt,
               no_step = failure.remedy == Remedy::none || too_short;
    std::string text = failure.text;
    if (!failure.cause.empty()) {
        text += "\n  cause: " + failure.cause;
        if (failure.remedy == Remedy::none)
            text += fmt::format("\n  a shorter step does not help: the same steps fail with time.dt = {:g} too",
                                failure.dt);
    } else if (too_short)
        text +=
            fmt::format("\n  likely cause: the loads on the rods; they would take steps of {:g} s, where one now has "
                        "{:g} s: weaken the load, or give the rods a larger radius or a larger youngs_modulus",
                        failure.dt, dt);
    else if (no_step)
        text += fmt::format(
            "\n  likely cause: the loads on the rods, or too few elements; a shorter step does not help: the same "
            "steps fail with time.dt = {:g} too; weaken the load, or give the rods more elements, a larger radius or a "
            "larger youngs_modulus",
            failure.dt);
    else if (!failure.likely.empty()) text += "\n  likely cause: " + failure.likely;
    else
        text += fmt::format("\n  likely cause: dt is {} the rest-state limit {:.4g} s{}",
                            ratio > 1 ? share_text(ratio) + " times" : share_text(ratio) + " of", plan.limit,
                            ratio > 1      ? "; lower dt"
                            : ratio > 0.95 ? ", too close to it; lower dt"
                                           : "; strains have grown beyond what it allows, or a load is too strong");
    if (!failure.frame.empty()) text += "\n  " + failure.frame;
    if (failure.remedy == Remedy::step)
        text += fmt::format("\n  the same steps hold with time.dt = {:g}: it was tried", failure.dt);
    if (failure.remedy == Remedy::untried && !no_step)
        text += fmt::format("\n  time.dt = {:g} may hold; to try it would take longer than {:g} s", failure.dt,
                            trial_seconds);
    std::string change = fmt::format("time.dt={:g}", failure.dt > 0 ? failure.dt : rounded_down(0.5 * dt));
    if (!failure.likely.empty() || no_step) change = failure.settings; // empty: no setting is known that would do
    if (last_checkpoint < 0)
        return text + "\n  there is no checkpoint yet: begin again in another directory" +
               (change.empty() ? ", with another scene" : ", with --set " + change);
    text += fmt::format("\n  the last good checkpoint is of step {}", last_checkpoint);
    if (change.empty())
        return text + fmt::format(": {}@{}; skein branch begins with it under other keys", directory, last_checkpoint);
    return text + fmt::format("; to continue from it:\n    skein branch {}@{} {}_2 --set {}", directory,
                              last_checkpoint, directory, change);
}

} // namespace skein
