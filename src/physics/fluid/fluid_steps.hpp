// Steps of a run with a fluid.
#pragma once

#include "physics/fluid/fluid_plan.hpp"
#include "plan/plan.hpp"

namespace skein {

/// A fluid by itself divides steps as its velocities want: one of the run goes from an output to the next, or part of
/// that way, so that a run sees signals and its walltime every so many steps of the fluid.
void choose_step_of_fluid(const FluidPlan& fluid, Plan& plan, const CoreTables& scene);
/// Steps of the fluid divide the interval, and steps of rods the stages of the fluid.
void divide_step_of_fluid(FluidPlan& fluid, Plan& plan, const CoreTables& scene, double longest);
/// Counts the given steps of rods in the longest step of the fluid. Throws InputError where it holds none.
void count_steps_in_fluid(FluidPlan& fluid, const Plan& plan, const CoreTables& scene);

} // namespace skein
