#include "plan/plan_steps.hpp"

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

/// Intervals of outputs that come at exact times: a checkpoint may come a step earlier or later.
std::vector<std::pair<std::string, double>> exact_intervals(const Plan& plan, const CoreTables& scene) {
    std::vector<std::pair<std::string, double>> intervals;
    for (const auto& [name, interval] : scene.output.intervals())
        if (interval > 0 && std::string_view(name) != "checkpoint") intervals.emplace_back(name, interval);
    for (const auto& one : plan.physics)
        for (auto& interval : one->output_intervals()) intervals.push_back(std::move(interval));
    return intervals;
}

} // namespace

Interval interval_to_divide(const Plan& plan, const CoreTables& scene, double longest_step, double least) {
    constexpr double fewest_steps = 8; // a step is up to an eighth shorter for it
    if (scene.time.divide > 0) return {scene.time.divide, "time.divide"};
    Interval shortest{scene.time.duration, "the duration"};
    double common = 0;
    for (const auto& [name, interval] : exact_intervals(plan, scene)) {
        if (interval < least * (1 - 1e-9)) continue;
        if (interval < shortest.length) shortest = {interval, name};
        common = common == 0 ? interval : common_divisor(std::max(common, interval), std::min(common, interval));
    }
    const bool together = common > 0 && common < shortest.length && common >= fewest_steps * longest_step;
    return together ? Interval{common, "common divisor of all output intervals"} : shortest;
}

std::string Interval::text() const { return fmt::format("{:g} s ({})", length, of); }

std::int64_t whole_steps(double interval, const Plan& plan) {
    const std::int64_t every = plan.events_every;
    return interval > 0
               ? every * std::max<std::int64_t>(1, std::llround(interval / (plan.dt * static_cast<double>(every))))
               : 0;
}

void find_governing(Plan& plan, const CoreTables& scene) {
    for (std::size_t g = 0; g < plan.groups.size(); ++g)
        // Written so that a limit which is no number governs too, and is refused.
        if (!(plan.groups[g].limits.front().dt >= plan.groups[plan.governing].limits.front().dt)) plan.governing = g;
    const GroupPlan& governing = plan.groups[plan.governing];
    const TimeLimit& limit = governing.limits.front();
    plan.limit = limit.dt * scheme_of(plan.integrator).stability;
    if (!(plan.limit > 0))
        throw InputError(fmt::format(
            "{}: the limit of the time step is {:g} s, set by the {} mode of element {} of '{}': look at the "
            "numbers of its material, section and shape",
            scene.file, plan.limit, limit.mode, limit.element, governing.name));
}

namespace {

/// The longest automatic step, s: a share of the limits, and no longer than physics accept.
double longest_step(const Plan& plan, const CoreTables& scene) {
    const TimeSpec& t = scene.time;
    double longest = plan.limit;
    for (const GroupPlan& g : plan.groups) {
        const double share = g.undamped ? std::min(undamped_share, t.safety * t.e_min) : t.safety * t.e_min;
        longest = std::min(longest, share * g.limits.front().dt * scheme_of(t.integrator).stability);
    }
    for (const auto& one : plan.physics) longest = std::min(longest, one->longest_step());
    return longest;
}

void require_limit(const Plan& plan, const CoreTables& scene) {
    if (!std::isfinite(plan.limit))
        throw InputError(fmt::format("{}: time.dt: nothing limits the time step, as there are none but rigid "
                                     "bodies without forces between them: give 'dt'",
                                     scene.file));
}

void refuse_beyond_limit(const Plan& plan, const CoreTables& scene) {
    const GroupPlan& governing = plan.groups[plan.governing];
    if (plan.dt > plan.limit && !plan.force_dt)
        throw InputError(fmt::format(
            "{}: time.dt = {:g} s is beyond the stable limit {:.6g} s, set by the {} mode of element {} of '{}'; "
            "use dt = \"auto\", a smaller dt, or force_dt = true",
            scene.file, plan.dt, plan.limit, governing.limits.front().mode, governing.limits.front().element,
            governing.name));
}

} // namespace

void choose_step(Plan& plan, const CoreTables& scene) {
    const TimeSpec& t = scene.time;
    const auto any = [&](auto&& of) {
        return std::any_of(plan.physics.begin(), plan.physics.end(), [&](const auto& one) { return of(*one); });
    };
    if (any([&](PhysicsPlan& one) { return one.sets_step(plan, scene); })) return;
    plan.integrator = t.integrator;
    plan.automatic_dt = t.dt == 0;
    plan.force_dt = t.force_dt;
    plan.rest_speed = t.rest_speed;
    find_governing(plan, scene);
    if (plan.automatic_dt) {
        const double longest = longest_step(plan, scene);
        if (!any([&](PhysicsPlan& one) { return one.divides_interval(plan, scene, longest); })) {
            require_limit(plan, scene);
            const Interval interval = interval_to_divide(plan, scene, longest);
            plan.divides = interval.text();
            plan.dt = interval.length / std::ceil(interval.length / longest);
        }
    } else {
        plan.dt = t.dt;
        for (const auto& one : plan.physics) one->take_given_step(plan, scene);
        refuse_beyond_limit(plan, scene);
    }
    plan.steps = whole_steps(t.duration, plan);
}

Cadence cadence_of(const OutputSpec& out, const Plan& plan) {
    Cadence cadence{.steps = {}, .checkpoint_wall = out.checkpoint_wall, .frames_wall = out.frames_wall};
    for (const auto& [name, interval] : out.intervals()) cadence.steps.emplace_back(name, whole_steps(interval, plan));
    return cadence;
}

std::vector<std::string> uneven_outputs(const Plan& plan, const CoreTables& scene) {
    std::vector<std::string> notes;
    const double event = plan.dt * static_cast<double>(plan.events_every);
    for (const auto& [name, interval] : exact_intervals(plan, scene)) {
        const double actual = std::max(1.0, std::round(interval / event)) * event;
        if (std::abs(actual - interval) > 1e-6 * interval)
            notes.push_back(fmt::format(
                "{} every {:g} s is no whole number of {}: it comes every {:.6g} s; {}", name, interval,
                plan.events_every > 1 ? fmt::format("intervals of {} steps", plan.events_every) : "steps", actual,
                plan.automatic_dt ? "time.divide names the interval that dt divides"
                                  : "a dt that divides it would do"));
    }
    return notes;
}

} // namespace skein
