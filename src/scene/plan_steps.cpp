#include "scene/plan_steps.hpp"

#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace skein {

namespace {

/// Undamped rods are lost after 1e5 steps and more above 0.707 of the limit, where modes go round in four steps or
/// fewer and strain drives them (tests/stress/resonance.cpp); at 0.6 their energy settles.
constexpr double undamped_share = 0.6;

/// Intervals of outputs that come at exact times: a checkpoint may come a step earlier or later.
std::vector<std::pair<std::string, double>> output_intervals(const SceneSpec& scene) {
    const OutputSpec& out = scene.output;
    std::vector<std::pair<std::string, double>> intervals = {{"trajectory", out.trajectory},
                                                             {"tips", out.tips},
                                                             {"series", out.series},
                                                             {"fields", out.fluid_fields},
                                                             {"contacts", out.contacts}};
    for (const FluidOutputSpec& of_fluid : scene.fluid_outputs) intervals.emplace_back(of_fluid.name, of_fluid.every);
    std::erase_if(intervals, [](const auto& i) { return i.second == 0; });
    return intervals;
}

/// The largest number that divides both, as written in a scene: Euclid's rule to a billionth.
double common_divisor(double a, double b) {
    const double small = 1e-9 * std::min(a, b);
    while (b > small) {
        a = std::fmod(a, b);
        if (b - a < small) a = 0; // a multiple, but for rounding
        std::swap(a, b);
    }
    return a;
}

struct Interval {
    double length = 0; ///< s
    std::string of;    ///< what it belongs to, in words
};

/// An automatic step divides this, so that outputs fall on whole steps: what the scene names, or else what divides all
/// intervals of outputs; where that is not much longer than the step may be, the shortest of them. Outputs that are
/// more frequent than `least` do not count.
Interval interval_to_divide(const SceneSpec& scene, double longest_step, double least = 0) {
    constexpr double fewest_steps = 8; // a step is up to an eighth shorter for it
    if (scene.time.divide > 0) return {scene.time.divide, "time.divide"};
    Interval shortest{scene.time.duration, "the duration"};
    double common = 0;
    for (const auto& [name, interval] : output_intervals(scene)) {
        if (interval < least * (1 - 1e-9)) continue;
        if (interval < shortest.length) shortest = {interval, name};
        common = common == 0 ? interval : common_divisor(std::max(common, interval), std::min(common, interval));
    }
    const bool together = common > 0 && common < shortest.length && common >= fewest_steps * longest_step;
    return together ? Interval{common, "what divides the intervals of all outputs"} : shortest;
}

void note_divided(Plan& plan, const Interval& interval) {
    plan.divides = fmt::format("{:g} s ({})", interval.length, interval.of);
}

/// Steps of 1 s, half of what M of theory.md (64) leaves: the limits of motion mean nothing.
void choose_relaxation(Plan& plan, const SceneSpec& scene) {
    plan.relax = plan.automatic_dt = plan.force_dt = true;
    plan.relax_tolerance = scene.time.relax_tolerance;
    plan.dt = 1;
    plan.limit = 2;
    plan.steps = std::max<std::int64_t>(1, std::llround(scene.time.duration));
}

/// A fluid by itself divides steps as its velocities want: one of the run goes from an output to the next, or part of
/// that way, so that a run sees signals and its walltime every so many steps of the fluid.
void choose_step_of_fluid(Plan& plan, const SceneSpec& scene) {
    const TimeSpec& t = scene.time;
    plan.automatic_dt = t.dt == 0;
    plan.limit = HUGE_VAL;
    const Interval interval = interval_to_divide(scene, 0);
    if (plan.automatic_dt) note_divided(plan, interval);
    constexpr double most = 64; // of them; their last part wastes a step at most
    const double of_fluid = interval.length / plan.fluid->step_limit(),
                 parts = of_fluid < most_fluid_steps ? std::ceil(of_fluid / most * (1 - 1e-12)) : 1;
    plan.dt = plan.automatic_dt ? interval.length / std::max(1.0, parts) : t.dt;
    plan.steps = std::max<std::int64_t>(1, std::llround(t.duration / plan.dt));
}

/// A step of the fluid lasts at most so long, s, by the speeds that the scene states. Where it states none, steps of a
/// run at rest would be as long as viscosity lets them: a share of the duration.
double longest_step_of_fluid(const FluidPlan& fluid, const TimeSpec& time) {
    constexpr double fewest = 64;
    return fluid.speed.value > 0 ? fluid.step_limit() : std::min(fluid.step_limit(), time.duration / fewest);
}

/// The shortest step that slip may ask for, s: about where it comes to the share of the speed that is allowed.
/// theory.md (95)
double shortest_step_of_fluid(const FluidPlan& fluid, double step) {
    constexpr double courant_per_slip = 0.6;
    const double speed = fluid.stated > 0 ? fluid.stated : fluid.speed.value;
    if (!(fluid.largest_slip > 0)) return step;
    const double courant = courant_per_slip * fluid.largest_slip;
    return speed > 0 ? courant * fluid.constants.grid.h / speed : step * courant / fluid.courant;
}

/// Steps of the fluid divide the interval, and steps of rods the stages of the fluid.
void divide_step_of_fluid(Plan& plan, const SceneSpec& scene, double longest) {
    FluidPlan& fluid = *plan.fluid;
    const auto unit = static_cast<double>(stage_parts(fluid.constants.scheme).unit);
    const double of_fluid = longest_step_of_fluid(fluid, scene.time);
    const Interval interval = interval_to_divide(scene, of_fluid, of_fluid);
    note_divided(plan, interval);
    const double step = interval.length / std::max(1.0, std::ceil(interval.length / of_fluid * (1 - 1e-12)));
    constexpr double fewest = 4; // and a smooth number: the fluid may divide them
    const double of_rods = std::min(longest, shortest_step_of_fluid(fluid, step) / unit);
    const std::int64_t parts =
        next_smooth(std::llround(std::max(fewest, std::ceil(step / (unit * of_rods) * (1 - 1e-12)))));
    plan.dt = step / (unit * static_cast<double>(parts));
    fluid.every = static_cast<std::int64_t>(unit) * parts;
}

/// Counts the given steps of rods in the longest step of the fluid.
void count_steps_in_fluid(Plan& plan, const SceneSpec& scene) {
    FluidPlan& fluid = *plan.fluid;
    const int unit = stage_parts(fluid.constants.scheme).unit;
    const double named = scene.time.divide > 0 ? scene.time.divide : scene.time.duration,
                 limit = std::min(longest_step_of_fluid(fluid, scene.time), named),
                 parts = std::floor(limit / (unit * plan.dt));
    if (parts < 1)
        throw InputError(fmt::format(
            "{}: time.dt = {:g} s: a step of the fluid, of {:.4g} s here, holds {} steps of rods with the "
            "scheme {}: at most {:.4g} s, or dt = \"auto\"",
            scene.file, plan.dt, limit, unit, nth(flow_scheme_names, fluid.constants.scheme), limit / unit));
    fluid.every = unit * static_cast<std::int64_t>(parts);
}

} // namespace

std::int64_t whole_steps(double interval, const Plan& plan) {
    const std::int64_t every = plan.events_every();
    return interval > 0
               ? every * std::max<std::int64_t>(1, std::llround(interval / (plan.dt * static_cast<double>(every))))
               : 0;
}

void choose_step(Plan& plan, const SceneSpec& scene) {
    const TimeSpec& t = scene.time;
    if (t.relax) return choose_relaxation(plan, scene);
    if (plan.groups.empty()) return choose_step_of_fluid(plan, scene);
    for (std::size_t g = 0; g < plan.groups.size(); ++g)
        // Written so that a limit which is no number governs too, and is refused.
        if (!(plan.groups[g].limits.front().dt >= plan.groups[plan.governing].limits.front().dt)) plan.governing = g;
    const GroupPlan& governing = plan.groups[plan.governing];
    const TimeLimit& limit = governing.limits.front();
    plan.integrator = t.integrator;
    plan.limit = limit.dt * scheme_of(t.integrator).stability;
    if (!(plan.limit > 0))
        throw InputError(fmt::format(
            "{}: the limit of the time step is {:g} s, set by the {} mode of element {} of '{}': look at the "
            "numbers of its material, section and shape",
            scene.file, plan.limit, limit.mode, limit.element, governing.name));
    plan.automatic_dt = t.dt == 0;
    plan.force_dt = t.force_dt;
    plan.rest_speed = t.rest_speed;
    if (plan.automatic_dt) {
        if (!std::isfinite(plan.limit))
            throw InputError(fmt::format("{}: time.dt: nothing limits the time step, as there are none but rigid "
                                         "bodies, which touch nothing: give 'dt'",
                                         scene.file));
        double longest = plan.limit;
        for (const GroupPlan& g : plan.groups) {
            const double share = g.undamped ? std::min(undamped_share, t.safety * t.e_min) : t.safety * t.e_min;
            longest = std::min(longest, share * g.limits.front().dt * scheme_of(t.integrator).stability);
        }
        longest = std::min(longest, plan.speeds.longest_step());
        if (plan.fluid) {
            divide_step_of_fluid(plan, scene, longest);
        } else {
            const Interval interval = interval_to_divide(scene, longest);
            note_divided(plan, interval);
            plan.dt = interval.length / std::ceil(interval.length / longest);
        }
    } else {
        plan.dt = t.dt;
        if (plan.fluid) count_steps_in_fluid(plan, scene);
        if (t.dt > plan.limit && !t.force_dt)
            throw InputError(fmt::format(
                "{}: time.dt = {:g} s is beyond the stable limit {:.6g} s, set by the {} mode of element {} of '{}'; "
                "use dt = \"auto\", a smaller dt, or force_dt = true",
                scene.file, t.dt, plan.limit, limit.mode, limit.element, governing.name));
    }
    plan.steps = whole_steps(t.duration, plan);
}

Cadence cadence_of(const OutputSpec& out, const Plan& plan) {
    const auto steps = [&](double interval) { return whole_steps(interval, plan); };
    return {.trajectory = steps(out.trajectory),
            .tips = steps(out.tips),
            .series = steps(out.series),
            .contacts = steps(out.contacts),
            .checkpoint = steps(out.checkpoint),
            .checkpoint_wall = out.checkpoint_wall,
            .frames_wall = out.frames_wall};
}

void tell_uneven_outputs(Plan& plan, const SceneSpec& scene) {
    const double event = plan.dt * static_cast<double>(plan.events_every());
    for (const auto& [name, interval] : output_intervals(scene)) {
        const double actual = std::max(1.0, std::round(interval / event)) * event;
        if (std::abs(actual - interval) > 1e-6 * interval)
            plan.notes.push_back(
                fmt::format("{} every {:g} s is no whole number of steps{}: it comes every {:.6g} s; {}", name,
                            interval, plan.events_every() > 1 ? " of the fluid" : "", actual,
                            plan.automatic_dt ? "time.divide names the interval that dt divides"
                                              : "a dt that divides it would do"));
    }
}

} // namespace skein
