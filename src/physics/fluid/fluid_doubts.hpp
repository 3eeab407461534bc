// Bodies that a grid of a fluid does not resolve, and how far off their drag will be.
#pragma once

#include "physics/fluid/fluid_plan.hpp"

#include <string>
#include <vector>

namespace skein {

/// One sentence for each group of rods and each obstacle of less than two cells in radius.
std::vector<std::string> fluid_doubts(const FluidPlan& fluid, std::span<const RodGroup> groups);

/// Error to expect of the drag across a round rod in slow flow, over its drag, by its radius and length in cells, from
/// the radius of the cylinder that has the drag measured: 0.78 cells with markers on the axis, 1.25, 1.74, 2.13 for
/// rings of 1, 1.5, 2 cells.
double drag_error(double radius, double length, bool on_axis);

} // namespace skein
