// The fluid in a printed plan.
#pragma once

#include "physics/fluid/fluid_plan.hpp"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <string>

namespace skein {

/// Lines of the printed plan, without their labels.
std::string fluid_text(const FluidPlan& fluid);
/// Drives besides inflow and obstacles; empty: none.
std::string drive_text(const FluidPlan& fluid);
std::string pressure_text(const FluidPlan& fluid, int ranks);
std::string sent_text(const FluidPlan& fluid, int ranks);
std::string rods_in_fluid_text(const RodsInFluid& rods, const FluidPlan& fluid);
std::string obstacle_text(const Obstacle& obstacle, const FluidPlan& fluid);
/// Output in a run of `steps` steps of dt, s.
std::string output_text(const FluidOutput& output, const FluidGrid& grid, std::int64_t steps, double dt);
std::string probe_text(const FluidProbeSpec& probe);
std::string fluid_steps_text(const FluidPlan& fluid, std::int64_t steps, double dt);
/// `cores`: that step it; `cores_per_node` 0: not known.
std::string fluid_cost_text(const FluidPlan& fluid, std::int64_t steps, double dt, int cores, int cores_per_node);
nlohmann::ordered_json fluid_json(const FluidPlan& fluid, std::int64_t steps, double dt, int ranks);

} // namespace skein
