// Test for whether a run writes the pressure of its fluid.
#pragma once

#include "physics/fluid/fluid_plan.hpp"

#include <algorithm>

namespace skein {

inline bool writes_pressure(const FluidPlan& fluid) {
    return std::any_of(fluid.outputs.begin(), fluid.outputs.end(), [](const FluidOutput& output) {
        return std::find(output.fields.begin(), output.fields.end(), CellField::pressure) != output.fields.end();
    });
}

} // namespace skein
