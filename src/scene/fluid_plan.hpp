// What a plan says of the fluid.
#pragma once

#include "scene/scene_spec.hpp"

#include <string>
#include <vector>

namespace skein {

/// The fluid around everything.
struct FluidPlan {
    FlowConstants constants;
    double courant = 0;
    std::vector<std::string> velocity_formula; ///< at the start
    std::vector<Obstacle> obstacles;
    ForcingNumbers forcing;
    FormulaScope names; ///< that it may hold

    static constexpr double bytes_per_cell = 96; ///< ten fields and coefficients, and as many to be sent on more ranks than one
    static constexpr double field_bytes_per_cell = 32; ///< of output
    /// Sent by a rank in a step: coefficients that change ranks and come back, and planes of ghosts.
    double transposed_bytes(int ranks) const;
    double ghost_bytes(int ranks) const;

    static constexpr double ns_per_cell_step = 45; ///< of three stages with one projection, for predictions
};

/// Of a scene that has a fluid.
FluidPlan plan_fluid(const SceneSpec& scene);

} // namespace skein
