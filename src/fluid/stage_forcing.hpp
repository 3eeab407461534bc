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
    /// Sets planes of ghosts across z of a field of each component. Collective.
    std::function<void(const std::array<double*, 3>& fields)> fill_ghost_planes;
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
