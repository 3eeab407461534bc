// What a run does about a failure: it goes back to the last copy of the state, makes the steps again looking at each,
// and says where it began.
#include "core/share_text.hpp"
#include "core/timer.hpp"
#include "core/two_digits.hpp"
#include "io/disk.hpp"
#include "kernels/kernels.hpp"
#include "mechanics/invalid_state.hpp"
#include "mechanics/rod_copies.hpp"
#include "simulation/branch.hpp"
#include "simulation/simulation.hpp"
#include "simulation/state_copy.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace skein {

namespace {

constexpr std::int64_t look_every = 64;   ///< steps of a first coarse search
constexpr std::int64_t copy_every = 1024; ///< steps between two copies at least: one costs as much as ten steps at most
constexpr std::int64_t copy_of_fluid_every = 32; ///< steps of a fluid: a copy costs as much as one at most
constexpr double held = 0.9;                     ///< share of a limit that is proposed
constexpr double resolved = 0.1;                 ///< of an element's length, or rad: what a load may do within a step
constexpr std::int64_t looked_back = 16;         ///< steps before a failure that may have led to it
constexpr std::int64_t tried_beyond = 50;        ///< steps to a failure for each behind it that is tried too
constexpr int most_attempts = 4;                 ///< at a shorter step, each a quarter of the one before
constexpr double trial_seconds = 8;              ///< wall time that they may take in all
constexpr double repeated_seconds = 2;           ///< of a run that a shorter step is tried on from its beginning
constexpr double repeated_bytes = 1 << 24;       ///< of the copy of that beginning
constexpr double shortest_proposed = 1e-4;       ///< of the step of the run
constexpr double telling_seconds = 0.5;          ///< of it, after which their pace is known
constexpr std::int64_t nobody = std::numeric_limits<std::int64_t>::max();

/// The worst of the passes, and what it did.
const PassEffect* worst_of(const std::vector<PassEffect>& effects) {
    const PassEffect* worst = nullptr;
    for (const PassEffect& e : effects) {
        if (!e.finite) return &e;
        if (e.share > 0 && (!worst || e.share > worst->share)) worst = &e;
    }
    return worst;
}

/// What it did to the rod; of numbers that are not finite more than of any other.
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

} // namespace

/// The invalid rod of lowest number on a rank.
struct Simulation::InvalidRod {
    std::int64_t gid = nobody;
    std::size_t rod = 0; ///< place in local()
    bool finite = true;
    bool limit = false;     ///< by its step alone
    std::string text, hint; ///< what is wrong with it; a line on its law, or none
};

void Simulation::keep_copy() {
    if (plan_.relax || options_.rewind == Rewind::never ||
        (options_.rewind == Rewind::automatic && plan_.copy_bytes == 0))
        return;
    if (clock_.done() % plan_.events_every() != 0) return; // within a step of the fluid
    const std::int64_t every = std::max(copy_every, plan_.fluid ? copy_of_fluid_every * plan_.events_every() : 0);
    if (copy_ && clock_.done() - copy_->step() < every) return;
    const auto timing = timers_.time(Phase::checkpoint);
    if (copy_ && copy_->owners() != owners_) copy_.reset(); // before there is another
    if (!copy_) copy_ = std::make_unique<StateCopy>(groups_, *rods_, owners_);
    copy_->take(*rods_, interactions_, clock_.done());
    const bool first = !std::exchange(was_copied_, true);
    if (first && plan_.predicted_s < repeated_seconds && plan_.copy_bytes > 0 && plan_.copy_bytes < repeated_bytes)
        first_copy_ = std::make_unique<StateCopy>(*copy_);
}

void Simulation::go_back(const StateCopy& copy) {
    if (copy.owners() != owners_) {
        copy.put_back_places(groups_);
        make_bodies(copy.owned());
        owners_ = copy.owners();
    }
    copy.put_back(*rods_, interactions_);
    clock_ = Clock(plan_.dt, copy.step(), plan_.integrator, clock_.shift());
}

bool Simulation::redo(std::int64_t until, bool look) {
    bool valid = true;
    while (clock_.done() < until) {
        const auto steps = clock_.next(std::min(until, next_coupling(interactions_, clock_.done())));
        const bool check = look && steps.back().index == until;
        valid = (is_coupled(plan_) ? step_coupled(steps, check) : step_uncoupled(steps, check)) || !check;
        clock_.advance(steps);
    }
    return comm_.max(static_cast<std::int64_t>(!valid)) == 0;
}

Simulation::InvalidRod Simulation::first_invalid_rod() const {
    InvalidRod first;
    std::vector<Slot<1>> state;
    const StepWatch watch = step_watch(plan_);
    for (std::size_t i = 0; i < rods_->local().size(); ++i) {
        const LocalRod& rod = rods_->local()[i];
        if (rod.gid >= first.gid) continue;
        const RodGroup& group = nth(groups_, rod.group);
        state.resize(static_cast<std::size_t>(group.slots()));
        rods_->export_rod(i, state);
        const std::string name = fmt::format("rod {} of '{}', ", rod.index, group.name());
        with_rod(group, rod.index, [&](const RodGroup& own) {
            if (const auto invalid = find_invalid(own, state)) {
                first = {rod.gid,
                         i,
                         invalid->finite,
                         false,
                         name + invalid->reason + tension_hint(own, state),
                         law_hint(own, state)};
            } else if (const Tightest at = tightest(own, state); watch.stops && watch.share(at.eigenvalue) > 1) {
                first = {rod.gid, i, true, true, name + text_of(at, watch), law_hint(own, state)};
            }
        });
    }
    return first;
}

double Simulation::present_limit() const {
    double least = HUGE_VAL;
    const StepWatch watch = step_watch(plan_);
    std::vector<Slot<1>> state;
    for (std::size_t i = 0; i < rods_->local().size(); ++i) {
        const LocalRod& rod = rods_->local()[i];
        const RodGroup& group = nth(groups_, rod.group);
        state.resize(static_cast<std::size_t>(group.slots()));
        rods_->export_rod(i, state);
        with_rod(group, rod.index, [&](const RodGroup& own) {
            if (!find_invalid(own, state)) least = std::min(least, watch.limit(tightest(own, state).eigenvalue));
        });
    }
    return comm_.min(std::min(least, step_limit(interactions_)));
}

/// From the copy 64 steps at a time until a rod becomes invalid, and those steps again one at a time.
Simulation::Failure Simulation::find_failure() {
    const std::int64_t failed_by = comm_.max(failure_.empty() ? std::int64_t{0} : clock_.done());
    const auto copy_here = [&] {
        auto copy = std::make_unique<StateCopy>(groups_, *rods_, owners_);
        copy->take(*rods_, interactions_, clock_.done());
        return copy;
    };
    balance_.stop();
    go_back(*copy_);
    std::unique_ptr<StateCopy> older, old = std::move(copy_);
    while (redo(std::min(failed_by, (clock_.done() / look_every + 1) * look_every), true)) {
        if (clock_.done() >= failed_by)
            return {.text =
                        comm_.first_text(failure_) + fmt::format("\n  the same steps, made again from step {}, went "
                                                                 "well: suspect this machine, and not the scene",
                                                                 (older ? older : old)->step())};
        older = std::move(old);
        old = copy_here();
    }
    const std::int64_t looked_at = old->step();                              // up to here all went well
    const std::unique_ptr<StateCopy> start = std::move(older ? older : old); // what went before may have led to it
    go_back(*start);
    redo(looked_at, false);
    while (redo(clock_.done() + 1, true)) {
    }

    Failure found{.step = clock_.done()};
    const InvalidRod mine = first_invalid_rod();
    const std::int64_t gid = comm_.min(mine.gid);
    const bool here = gid != nobody && mine.gid == gid;
    if (gid == nobody) { // contacts alone
        found.text = comm_.first_text(reason_of_failure());
        found.cause = comm_.first_text(cause(interactions_));
    } else {
        found.text = comm_.first_text(here ? fmt::format("{} at step {} (t = {:.6g} s, dt = {:.6g} s){}", mine.text,
                                                         found.step, clock_.time(), plan_.dt, mine.hint)
                                           : std::string());
    }
    try {
        write_single_frame(comm_, options_.out, "failure", groups_, *rods_, plan_.title, found.step, clock_.time(),
                           clock_.lag());
        found.frame =
            fmt::format("all rods at step {}: {}/failure.h5, for ParaView failure.xdmf", found.step, options_.out);
        for (const auto& output : outputs_) output->follow(*rods_);
        write_end(true);
    } catch (const IoError& error) { // the failure is what the run ends with
        if (found.frame.empty()) found.frame = fmt::format("failure.h5 was not written: {}", error.what());
    }

    double limit = HUGE_VAL;
    if (gid == nobody || comm_.max(static_cast<std::int64_t>(here && mine.limit)) != 0) limit = present_limit();
    if (gid != nobody) {
        // A shape that is out of bounds has come from the loads of the steps before.
        const bool shape = comm_.max(static_cast<std::int64_t>(here && mine.finite)) != 0;
        const std::int64_t last = std::max(start->step() + 1, found.step - shape),
                           first = std::max(start->step(), last - looked_back);
        std::vector<PassEffect> worst;
        std::int64_t began = last;
        Touch touch;
        std::int64_t touched = last;
        go_back(*start);
        redo(first, false);
        for (std::int64_t step = first + 1; step <= last; ++step) {
            const auto before = copy_here();
            if (step == last) limit = std::min(limit, present_limit());
            redo(step, false); // so that contacts are those of this step
            if (!interactions_.empty())
                if (const Touch now = strongest_touch(comm_, interactions_, gid); now.force > touch.force) {
                    touch = now;
                    touched = step;
                }
            go_back(*before);
            if (here) {
                auto effects = rods_->dissect(mine.rod, clock_.next(step, 1));
                if (worst.empty() || share_of(effects) > share_of(worst)) {
                    worst = std::move(effects);
                    began = step;
                }
            }
            go_back(*before);
            redo(step, false);
        }
        found.text += comm_.first_text(here ? fmt::format("\n  where it began: step {}, {}", began, story_of(worst))
                                            : std::string());
        if (!touch.text.empty()) found.text += fmt::format("\n  touched: at step {} {}", touched, touch.text);
        const double share = comm_.max(here ? share_of(worst) : 0);
        if (share > resolved) limit = std::min(limit, plan_.dt * std::sqrt(resolved / share) / held);
    }
    if (plan_.events_every() > 1) return found; // a fluid goes on from ends of its own steps alone
    const std::int64_t last_tried = found.step + std::max(look_every, found.step / tried_beyond);
    const double beyond = clock_.shift() + static_cast<double>(last_tried) * plan_.dt;
    try_shorter_steps(found, *start, beyond, rounded_down(std::min(held * limit, 0.5 * plan_.dt)));
    return found;
}

void Simulation::begin_again(const StateCopy& start, const Clock& was) {
    const std::vector<LocalRod>& owned = start.owned();
    if (start.owners() != owners_) {
        start.put_back_places(groups_);
        owners_ = start.owners();
    }
    clock_ = continued(was, plan_.dt, plan_.integrator);
    make_bodies(owned);
    for (std::size_t i = 0; i < owned.size(); ++i) {
        std::vector<Slot<1>> state(start.state(i).begin(), start.state(i).end());
        with_rod(nth(groups_, owned[i].group), owned[i].index,
                 [&](const RodGroup& own) { synchronise(own, state, was.lag() - clock_.lag()); }); // theory.md (63)
        rods_->import_rod(i, state);
        if (!start.memory(i).empty()) rods_->set_memory(i, start.memory(i));
    }
    restore(interactions_, start.saved());
}

void Simulation::try_shorter_steps(Failure& failure, const StateCopy& start, double until, double dt) {
    const double began = wall_seconds();
    const double dt_of_run = plan_.dt, shift = clock_.shift();
    enum class Trial { held, failed, too_long };
    const auto tried = [&](const StateCopy& from, double step) {
        plan_.dt = step;
        begin_again(from, Clock(dt_of_run, from.step(), plan_.integrator, shift));
        const double first = static_cast<double>(clock_.done()), trial_began = wall_seconds();
        for (const std::int64_t end = clock_.step_at(until); clock_.done() < end;) {
            if (!redo(std::min(end, clock_.done() + look_every), true)) return Trial::failed;
            const double now = wall_seconds(), taken = comm_.max(now - trial_began);
            const double share = (static_cast<double>(clock_.done()) - first) / (static_cast<double>(end) - first);
            const bool hopeless = taken > telling_seconds && taken > share * trial_seconds;
            if (hopeless || comm_.max(now - began) > trial_seconds) return Trial::too_long;
        }
        return Trial::held;
    };
    for (int attempt = 0; attempt < most_attempts; ++attempt, dt = rounded_down(dt / 4)) {
        failure.dt = dt;
        Trial trial = tried(start, dt);
        // A step that holds by chance, as for rods that fold, fails with half of it or from the beginning.
        if (trial == Trial::held && tried(start, rounded_down(dt / 2)) == Trial::failed) trial = Trial::failed;
        if (trial == Trial::held && first_copy_ && tried(*first_copy_, dt) == Trial::failed) trial = Trial::failed;
        if (trial == Trial::failed) continue;
        failure.remedy = trial == Trial::held ? Remedy::step : Remedy::untried;
        return;
    }
    failure.remedy = Remedy::none;
}

void Simulation::throw_failure() {
    progress_->finish();
    try { // frames and rows before the failure are good
        close_files();
        finish_files();
    } catch (const IoError&) { // the failure is what the run ends with
    }
    if (plan_.relax)
        throw NumericalError(comm_.first_text(failure_) +
                             "\n  the relaxation has left the way to rest: give a start nearer to it, "
                             "weaker loads or more elements");
    if (groups_.empty()) {
        std::string text = comm_.first_text(failure_);
        if (last_checkpoint_ >= 0) text += fmt::format("\n  the last good checkpoint is of step {}", last_checkpoint_);
        throw NumericalError(text);
    }
    const double dt = plan_.dt, ratio = dt / plan_.limit;
    const auto settings = [&] {
        return comm_.first_text(fmt::format("{}", fmt::join(remedies(interactions_), " --set ")));
    };
    Failure found{
        .text = comm_.first_text(failure_), .cause = comm_.first_text(cause(interactions_)), .settings = settings()};
    const std::string of_fluid = fluid_of(interactions_) ? found.settings : std::string();
    if (copy_) {
        const auto timing = timers_.time(Phase::rods);
        found = find_failure();
        if (!found.cause.empty()) found.settings = settings();
    }
    std::string text = found.text;
    // A step so short that no run would end is no remedy.
    const bool no_step =
        found.remedy == Remedy::none || (found.remedy == Remedy::untried && found.dt < shortest_proposed * dt);
    if (!found.cause.empty()) {
        text += "\n  cause: " + found.cause;
        if (found.remedy == Remedy::none)
            text +=
                fmt::format("\n  a shorter step does not help: the same steps fail with time.dt = {:g} too", found.dt);
    } else if (no_step && found.remedy == Remedy::untried)
        text += fmt::format("\n  likely cause: what acts on the rods; it would take steps of {:g} s, where one now has "
                            "{:g} s: weaken the "
                            "load, or give the rods a larger radius or a larger youngs_modulus",
                            found.dt, dt);
    else if (no_step)
        text += fmt::format(
            "\n  likely cause: what acts on the rods, or too few elements; a shorter step does not help: the same "
            "steps "
            "fail with time.dt = {:g} too; weaken the load, or give the rods more elements, a larger radius or a "
            "larger youngs_modulus",
            found.dt);
    else if (!of_fluid.empty())
        text += "\n  likely cause: fluid and rods move faster than steps of the fluid were planned for";
    else
        text +=
            fmt::format("\n  likely cause: dt is {} of the rest-state limit {:.4g} s{}", share_text(ratio), plan_.limit,
                        ratio > 0.95 ? ", too close to it; lower dt"
                                     : "; strains have grown beyond what it allows, or a load is too strong");
    if (!found.frame.empty()) text += "\n  " + found.frame;
    if (found.remedy == Remedy::step)
        text += fmt::format("\n  the same steps hold with time.dt = {:g}: it was tried", found.dt);
    if (found.remedy == Remedy::untried && !no_step)
        text += fmt::format("\n  time.dt = {:g} may hold; to try it would take longer than {:g} s", found.dt,
                            trial_seconds);
    const std::string change = !of_fluid.empty() ? of_fluid
                               : no_step
                                   ? (found.settings.empty() ? std::string("KEY=VALUE") : found.settings)
                                   : fmt::format("time.dt={:g}", found.dt > 0 ? found.dt : rounded_down(0.5 * dt));
    if (last_checkpoint_ >= 0)
        text += fmt::format("\n  the last good checkpoint is of step {}; to go on from it:\n"
                            "    skein branch {}@{} {}_2 --set {}",
                            last_checkpoint_, options_.out, last_checkpoint_, options_.out, change);
    else text += fmt::format("\n  there is no checkpoint yet: begin again in another directory, with --set {}", change);
    throw NumericalError(text);
}

} // namespace skein
