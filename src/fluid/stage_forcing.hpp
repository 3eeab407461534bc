// What bodies do to a fluid within a stage of its step.
#pragma once

#include <array>
#include <functional>

namespace skein {

/// A flow after a stage without its bodies and before its projection.
struct FlowStage {
    std::array<double*, 3> velocity; ///< of this rank, as FlowSolver::layout() has them
    std::array<double*, 3> scratch;  ///< as large, of no meaning
    double time;                     ///< at the end of the stage, s
    /// Sets ghosts of velocities beyond walls: across x and y in planes of this rank for which `sides` says so, and with `beyond`
    /// across z. This rank alone.
    std::function<void(const std::function<bool(int plane)>& sides, bool beyond)> fill_beyond_walls;
};

class StageForcing {
public:
    virtual ~StageForcing() = default;
    /// Changes velocities of this rank's cells; their ghosts are set afterwards. Collective.
    virtual void apply(const FlowStage& stage) = 0;
    /// Of this rank's planes of cells, whether it changed some of one in the last stage.
    virtual bool changed(int plane) const = 0;
};

} // namespace skein
