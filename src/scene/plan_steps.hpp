// The step of a plan, and the steps at which outputs come.
#pragma once

#include "scene/plan.hpp"

#include <cstdint>

namespace skein {

/// Sets dt, its limit and the number of steps, when groups have their limits and the fluid its own. Throws InputError
/// where a given step is too long.
void choose_step(Plan& plan, const SceneSpec& scene);
/// Steps of an interval, s, those of the fluid where rods are in it; at least one, and 0 of no interval.
std::int64_t whole_steps(double interval, const Plan& plan);
Cadence cadence_of(const OutputSpec& out, const Plan& plan);
/// Notes outputs that come at other times than asked for.
void tell_uneven_outputs(Plan& plan, const SceneSpec& scene);

} // namespace skein
