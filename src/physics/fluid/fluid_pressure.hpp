// Test for whether a run writes the pressure of its fluid, in files or columns.
#pragma once

#include "physics/fluid/fluid_plan.hpp"

#include <algorithm>

namespace skein {

inline bool writes_pressure(const FluidPlan& fluid) {
    return !fluid.probes.empty() ||
           std::any_of(fluid.outputs.begin(), fluid.outputs.end(), [](const FluidOutput& output) {
               return std::find(output.fields.begin(), output.fields.end(), CellField::pressure) != output.fields.end();
           });
}

} // namespace skein
