#include "studies/method_trial.hpp"

#include "core/memory.hpp"
#include "parallel/threads.hpp"
#include "plan/method_costs.hpp"
#include "plan/plan_words.hpp"
#include "plan/stepping_cost.hpp"
#include "scene/make_plan.hpp"
#include "simulation/world.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "studies/touching_trial.hpp"
#include "tiles/clusters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace skein {

namespace {

constexpr double least_predicted = 2; // s: what takes less begins at once
constexpr double longest_trial = 1, share_of_run = 0.05;
constexpr std::int64_t sampled_elements = 4000;        // of a trial
constexpr std::int64_t most_joined_elements = 1000;    // of a copy: more may take longer than a trial for one step
constexpr std::int64_t most_joined_in_all = 10'000;    // of copies that touch: the same
constexpr std::int64_t most_copied_elements = 300'000; // with lists or sizes of their own: a second to set up
constexpr double share_of_memory = 0.25;               // share of what is free
/// Core time of this thread: other programs may use the core too.
double thread_seconds() {
    std::timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

bool steps_either_way(const SceneSpec& scene, std::span<const RodGroup> groups) {
    if (scene.time.relax || groups.empty() || (scene.fluid && rods_touch(scene))) return false;
    if (!std::all_of(groups.begin(), groups.end(), [](const RodGroup& of) { return of.places().holds_all(); }))
        return false;
    for (const AssemblyGroups& joined : assemblies_of(groups))
        if (joined.elements_per_copy() > most_joined_elements) return false;
    return accepts_integrator(with_integrator(scene, Integrator::implicit_damped));
}

/// True of a scene that can be tried as a whole on this process.
bool whole_is_tried(const Plan& plan, const SceneSpec& scene, std::span<const RodGroup> groups) {
    const std::int64_t most = assemblies_of(groups).empty() ? most_copied_elements : most_joined_in_all;
    return plan.machine.ranks == 1 && plan.elements <= most && scene.start.from.empty() &&
           plan.state_bytes < share_of_memory * free_memory();
}

/// A tile of rods of each group at equal distances in its list, of as many groups as a trial holds.
struct SampledRods {
    std::vector<LocalRod> rods;
    std::vector<std::int64_t> counts; ///< by group
};

SampledRods sampled_rods(const Plan& plan, std::span<const RodGroup> groups) {
    SampledRods sample{{}, std::vector<std::int64_t>(groups.size(), 0)};
    std::int64_t elements = 0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const RodGroup& group = groups[g];
        if (!group.assembly() && elements >= sampled_elements) continue;
        const std::int64_t together = group.assembly() ? group.rods_per_copy() : 1, all = group.count() / together,
                           most = std::min<std::int64_t>(all, plan.machine.lanes);
        sample.counts[g] = most * together;
        elements += most * together * group.elements();
        for (std::int64_t i = 0; i < most * together; ++i) {
            const std::int64_t rod = i / together * all / most * together + i % together;
            sample.rods.push_back({group.first_gid() + rod, group.id(), rod});
        }
    }
    return sample;
}

/// Some rods of a scene that take steps, timed.
class Trial {
public:
    explicit Trial(const PlannedMethod& method) : Trial(method.plan, method.groups) {}
    Trial(const Plan& plan, std::span<const RodGroup> groups)
        : sample_(sampled_rods(plan, groups)), threads_(1),
          world_(threads_, std::vector<RodGroup>(groups.begin(), groups.end()), on_one_thread(plan), sample_.rods) {}

    World& world() { return world_; }
    /// Time of a run by this plan over that of the trial, for as many steps.
    double scale(const Plan& run) const {
        return stage_ns(run, largest_share(run), std::min(run.machine.threads, run.machine.cores)) /
               stage_ns(world_.plan, sample_.counts, 1);
    }
    /// Time of a step or part, as the plan predicts it, s.
    double step_seconds() const {
        const auto stages = static_cast<double>(scheme_of(world_.plan.integrator).stages.size());
        return 1e-9 * stages * stage_ns(world_.plan, sample_.counts, 1);
    }
    /// Makes steps, at most up to `end`, and for as long as `budget`, s, allows; false where the rods do not go on.
    bool advance(std::int64_t steps, std::int64_t end, double budget) {
        const double began = thread_seconds();
        world_.give_up_when([this, began, budget] { return spent_ + thread_seconds() - began > budget; });
        world_.advance(std::min(end, world_.clock.done() + steps));
        spent_ += thread_seconds() - began;
        return world_.failure().empty() && !world_.gave_up();
    }
    double spent() const { return spent_; } ///< s
    /// Time of a step in as many parts as the present one, without failed attempts, s.
    double seconds_of_step() const {
        return spent_ / static_cast<double>(std::max<std::int64_t>(1, world_.parts_made())) *
               static_cast<double>(world_.parts_of_step());
    }
    std::int64_t done() const { return world_.clock.done(); }
    /// Largest distance of a node from where another trial of the same rods has it, m.
    double distance_to(const Trial& other) const {
        double most = 0;
        const Rods &a = world_.rods(), &b = other.world_.rods();
        for (std::size_t i = 0; i < a.local().size(); ++i) {
            const std::size_t slots = to_index(nth(world_.groups, a.local()[i].group).slots());
            std::vector<Slot<1>> of_a(slots), of_b(slots);
            a.export_rod(i, of_a);
            b.export_rod(i, of_b);
            for (std::size_t k = 0; k < slots; ++k)
                most = std::max(most, norm(lane(of_a[k].position, 0) - lane(of_b[k].position, 0)));
        }
        return most;
    }

private:
    static Plan on_one_thread(Plan plan) {
        plan.machine.ranks = plan.machine.threads = plan.machine.cores = 1;
        return plan;
    }

    SampledRods sample_;
    Threads threads_;
    World world_;
    double spent_ = 0;
};

double largest_length(std::span<const RodGroup> groups) {
    double length = 0;
    for (const RodGroup& group : groups) length = std::max(length, group.spec().shape.length);
    return length;
}

/// Last step of the first stage, as trials stay in it.
std::int64_t last_step_of_stage(const Plan& plan) {
    const double until = plan.stages.empty() ? 0 : plan.stages.front().duration;
    return until > 0 ? std::clamp<std::int64_t>(std::llround(until / plan.dt), 1, plan.steps) : plan.steps;
}

/// Core time of an explicit step of the trial, s; 0: the rods fail.
double time_of_step(Trial& trial, double budget) {
    const std::int64_t end = last_step_of_stage(trial.world().plan);
    if (!trial.advance(Clock::largest_batch, end, budget)) return 0; // in memory that no one has touched
    const std::int64_t warm = trial.done();
    const double before = trial.spent();
    while (trial.done() < end && trial.spent() < budget)
        if (!trial.advance(Clock::largest_batch, end, budget)) return 0;
    return trial.done() > warm ? (trial.spent() - before) / static_cast<double>(trial.done() - warm)
                               : before / static_cast<double>(warm);
}

/// Error of Verlet's steps over that of implicit ones, for this ratio of their lengths. Slow motion of frequency w has
/// that of phase: (w h)^2/24 by Verlet, (w h)^2/12 by the midpoint rule, 0.97 (w h)^2/24 by the damped scheme.
double ratio_of_errors(Integrator implicit, double ratio) {
    return (implicit == Integrator::implicit ? 0.5 : 1.0) * ratio * ratio;
}

/// Cost of a whole run.
struct ImplicitCost {
    double seconds = 0, error = 0, explicit_error = 0; ///< core time of the rods of the trial; m
    double covered = 0;                                ///< share of the duration that the trial came to
};

/// Sum over all steps of a run, from the sums after each of its first ones. The steps that are left are as the later
/// half of these: motion at the start may need more parts than all that follows.
double whole_sum(const std::vector<double>& sums, std::int64_t steps) {
    const std::size_t half = sums.size() / 2;
    const double before = half > 0 ? sums[half - 1] : 0,
                 left = static_cast<double>(steps) - static_cast<double>(sums.size());
    return sums.back() + left * (sums.back() - before) / static_cast<double>(sums.size() - half);
}

/// Steps in parts by the tolerance. Explicit steps have the length `dt` and take `step` seconds.
std::optional<ImplicitCost> cost_by_tolerance(Trial& trial, double dt, double step, double budget) {
    const Plan& plan = trial.world().plan;
    const std::int64_t end = last_step_of_stage(plan);
    StepControl& control = *step_control(trial.world().interactions());
    const double part = 2 * trial.step_seconds(),  // as predicted, and twice as many corrections
        most = std::max(4.0, budget / (3 * part)); // with the attempts before
    control.limit(static_cast<std::int64_t>(most));
    std::vector<double> seconds, errors;
    double explicit_error = 0;
    while (trial.done() < end && trial.spent() < budget) {
        if (!trial.advance(1, end, 2 * budget)) {
            const double least = std::max(most * part, trial.seconds_of_step());
            if (least < plan.dt / dt * step) return std::nullopt; // more parts might pay
            return ImplicitCost{.seconds = std::numeric_limits<double>::infinity()};
        }
        const double h = plan.dt / static_cast<double>(control.parts());
        explicit_error += control.error() * ratio_of_errors(plan.integrator, dt / h);
        seconds.push_back(trial.spent());
        errors.push_back(explicit_error);
    }
    return ImplicitCost{.seconds = whole_sum(seconds, plan.steps),
                        .explicit_error = whole_sum(errors, plan.steps),
                        .covered = static_cast<double>(trial.done()) / static_cast<double>(plan.steps)};
}

/// Steps of a given length. Others of half their length tell their error.
std::optional<ImplicitCost> cost_of_given(Trial& trial, const SceneSpec& scene, double dt, double budget) {
    const Plan& plan = trial.world().plan;
    const std::int64_t end = last_step_of_stage(plan);
    SceneSpec finer = scene;
    finer.time.dt = 0.5 * plan.dt;
    Trial half(make_plan(finer, trial.world().groups, plan.machine), trial.world().groups);
    std::vector<double> seconds;
    double error = 0;
    while (trial.done() < end && trial.spent() + half.spent() < budget) {
        if (!trial.advance(1, end, 2 * budget) || !half.advance(2, 2 * end, 2 * budget)) return std::nullopt;
        error = std::max(error, 4.0 / 3 * trial.distance_to(half));
        seconds.push_back(trial.spent());
    }
    const double covered = static_cast<double>(trial.done()) / static_cast<double>(plan.steps);
    error /= covered; // as it grows with time
    return ImplicitCost{.seconds = whole_sum(seconds, plan.steps),
                        .error = error,
                        .explicit_error = error * ratio_of_errors(plan.integrator, dt / plan.dt),
                        .covered = covered};
}

/// `scene`: by implicit steps.
std::optional<MethodCosts> trials(const PlannedMethod& first, const PlannedMethod& second, const SceneSpec& scene) {
    const Plan &of_explicit = first.plan, &of_implicit = second.plan;
    const double budget = std::min(longest_trial, share_of_run * of_explicit.predicted_s);
    Trial by_explicit(first), by_implicit(second);
    const double step = time_of_step(by_explicit, 0.1 * budget);
    if (step == 0) return std::nullopt;
    MethodCosts costs;
    costs.of_explicit = {of_explicit.integrator,
                         step * static_cast<double>(of_explicit.steps) * by_explicit.scale(of_explicit), 0};
    const double left = 0.9 * budget, length = largest_length(first.groups);
    const auto cost = of_implicit.automatic_dt ? cost_by_tolerance(by_implicit, of_explicit.dt, step, left)
                                               : cost_of_given(by_implicit, scene, of_explicit.dt, left);
    if (!cost) return std::nullopt;
    costs.of_implicit = {of_implicit.integrator, cost->seconds * by_implicit.scale(of_implicit),
                         of_implicit.automatic_dt ? scene.time.tolerance : cost->error / length};
    if (of_explicit.integrator == Integrator::verlet) costs.of_explicit.error = cost->explicit_error / length;
    costs.trial_s = by_explicit.spent() + by_implicit.spent();
    costs.covered = cost->covered;
    return costs;
}

/// The scene without its fluid, for the time of the rods in steps of this length, s.
SceneSpec without_fluid(SceneSpec scene, double dt) {
    scene.fluid.reset();
    scene.obstacles.clear();
    scene.fluid_outputs.clear();
    scene.fluid_probes.clear();
    scene.time.dt = dt;
    scene.time.force_dt = !is_implicit(scene.time.integrator); // the fluid's inertia may allow for longer steps
    return scene;
}

/// Costs in a fluid, of which the fluid's own part is that of its plan, and the rods' part is tried without it. Errors
/// are due to the fluid's steps.
std::optional<MethodCosts> costs_in_fluid(const PlannedMethod& first, const PlannedMethod& second,
                                          const SceneSpec& scene) {
    const double budget = 0.5 * std::min(longest_trial, share_of_run * first.plan.predicted_s);
    MethodCosts costs;
    const auto cost_of = [&](const PlannedMethod& method) -> std::optional<MethodCosts::Cost> {
        const Plan& plan = method.plan;
        const SceneSpec dry = without_fluid(with_integrator(scene, plan.integrator), plan.dt * plan.steps_at_once);
        const Plan rods = make_plan(dry, method.groups, plan.machine);
        Trial trial(rods, method.groups);
        const double step = time_of_step(trial, budget);
        if (step == 0) return std::nullopt;
        double seconds = step * static_cast<double>(plan.steps) / plan.steps_at_once * trial.scale(rods);
        for (const auto& one : plan.physics)
            seconds += one->core_seconds(plan) / std::min(plan.machine.threads, plan.machine.cores);
        costs.trial_s += trial.spent();
        return MethodCosts::Cost{plan.integrator, seconds, 0};
    };
    const auto by_explicit = cost_of(first), by_implicit = cost_of(second);
    if (!by_explicit || !by_implicit) return std::nullopt;
    costs.of_explicit = *by_explicit;
    costs.of_implicit = *by_implicit;
    return costs;
}

} // namespace

bool methods_are_compared(const Plan& plan, const SceneSpec& scene, std::span<const RodGroup> groups) {
    return (is_implicit(plan.integrator) || plan.predicted_s >= least_predicted) && steps_either_way(scene, groups) &&
           (!rods_touch(scene) || whole_is_tried(plan, scene, groups)) &&
           ((!has_rods_of_files(groups) && assemblies_of(groups).empty()) || plan.elements <= most_copied_elements) &&
           (!scene.fluid || plan.machine.ranks == 1);
}

namespace {

std::optional<MethodCosts> costs_of(const Plan& plan, const SceneSpec& scene, std::span<const RodGroup> groups) {
    if (rods_touch(scene)) return touching_costs(plan, scene, groups);
    Machine machine = plan.machine;
    if (machine.most_lanes > 0) machine.lanes = machine.most_lanes;
    const bool implicit = is_implicit(plan.integrator);
    const SceneSpec changed = with_integrator(scene, implicit ? Integrator::verlet : Integrator::implicit_damped);
    const PlannedMethod own(plan, groups), other(changed, groups, machine);
    const PlannedMethod &of_explicit = implicit ? other : own, &of_implicit = implicit ? own : other;
    if (of_explicit.plan.predicted_s < least_predicted) return std::nullopt;
    if (scene.fluid) return costs_in_fluid(of_explicit, of_implicit, scene);
    return trials(of_explicit, of_implicit, implicit ? scene : changed);
}

} // namespace

void compare_methods(Plan& plan, const SceneSpec& scene, std::span<const RodGroup> groups) {
    std::optional<MethodCosts> costs;
    try {
        costs = costs_of(plan, scene, groups);
    } catch (const Error&) {
        return; // one of the methods refuses the scene
    }
    if (!costs) return;
    const double now = (is_implicit(plan.integrator) ? costs->of_implicit : costs->of_explicit).seconds;
    if (plan.predicted_by.empty()) {
        if (std::isfinite(now)) {
            plan.predicted_s = now;
            plan.predicted_by = fmt::format("trials of {:.2g} s", costs->trial_s);
        }
    } else if (plan.integrator == Integrator::implicit || plan.integrator == Integrator::implicit_damped) {
        costs->of_implicit.seconds = plan.predicted_s; // in parts as they were made
    } else if (plan.predicted_most_s == 0) { // more steps of this method have been timed, and no bed has yet to form
        costs->of_explicit.seconds *= plan.predicted_s / now;
        costs->of_implicit.seconds *= plan.predicted_s / now;
    }
    plan.methods = std::make_shared<const MethodCosts>(*costs);
}

} // namespace skein
