#include "physics/fluid/fluid_steps.hpp"

#include "physics/fluid/fluid_plan.hpp"
#include "plan/plan_steps.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

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

} // namespace

void choose_step_of_fluid(const FluidPlan& fluid, Plan& plan, const CoreTables& scene) {
    const TimeSpec& t = scene.time;
    plan.automatic_dt = t.dt == 0;
    plan.limit = HUGE_VAL;
    const Interval interval = interval_to_divide(plan, scene, 0);
    if (plan.automatic_dt) plan.divides = interval.text();
    constexpr double most = 64; // of them; their last part wastes a step at most
    const double of_fluid = interval.length / fluid.step_limit(),
                 parts = of_fluid < most_fluid_steps ? std::ceil(of_fluid / most * (1 - 1e-12)) : 1;
    plan.dt = plan.automatic_dt ? interval.length / std::max(1.0, parts) : t.dt;
    plan.steps = std::max<std::int64_t>(1, std::llround(t.duration / plan.dt));
}

void divide_step_of_fluid(FluidPlan& fluid, Plan& plan, const CoreTables& scene, double longest) {
    const auto unit = static_cast<double>(stage_parts(fluid.constants.scheme).unit);
    const double of_fluid = longest_step_of_fluid(fluid, scene.time);
    const Interval interval = interval_to_divide(plan, scene, of_fluid, of_fluid);
    plan.divides = interval.text();
    const double step = interval.length / std::max(1.0, std::ceil(interval.length / of_fluid * (1 - 1e-12)));
    constexpr double fewest = 4; // and a smooth number: the fluid may divide them
    const double of_rods = std::min(longest, shortest_step_of_fluid(fluid, step) / unit);
    const std::int64_t parts =
        next_smooth(std::llround(std::max(fewest, std::ceil(step / (unit * of_rods) * (1 - 1e-12)))));
    plan.dt = step / (unit * static_cast<double>(parts));
    fluid.every = static_cast<std::int64_t>(unit) * parts;
}

void count_steps_in_fluid(FluidPlan& fluid, const Plan& plan, const CoreTables& scene) {
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

} // namespace skein
