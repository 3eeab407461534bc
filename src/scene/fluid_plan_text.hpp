// What a printed plan says of the fluid.
#pragma once

#include "scene/fluid_plan.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace skein {

/// Lines of the printed plan, without their labels.
std::string fluid_text(const FluidPlan& fluid);
std::string obstacle_text(const Obstacle& obstacle, const FluidPlan& fluid);
nlohmann::ordered_json fluid_json(const FluidPlan& fluid);

} // namespace skein
