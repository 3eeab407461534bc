// What bodies do to a fluid within a stage of its step.
#pragma once

#include <array>
#include <functional>

namespace skein {

/// What an implicit stage makes of pushes, in `scratch` of the stage.
class StageResponse {
public:
    virtual ~StageResponse() = default;
    /// Sets it to 0.
    virtual void clear() = 0;
    /// From pushes, m/s without viscosity and ghosts aside, to the changes of velocity at the end of the stage, by
    /// viscosity and free of divergence, with their ghosts. Collective.
    virtual void respond() = 0;
    /// Adds so many times these changes to the velocity, and what belongs to them to the pressure.
    virtual void add(double times) = 0;
};

/// A flow after a stage without its bodies: where that is explicit, before its projection.
struct FlowStage {
    std::array<double*, 3> velocity; ///< of this rank, as FlowSolver::layout() has them
    std::array<double*, 3> scratch;  ///< as large, of no meaning
    double time;                     ///< at the end of the stage, s
    double dt;                       ///< of the stage, s
    bool ends_step;                  ///< the last stage of a step
    StageResponse* response;         ///< null: the stage is explicit, and pushes are changes of velocity
    /// Sets ghosts of velocities beyond walls: across x and y in planes of this rank for which `sides` says so, and
    /// with `beyond` across z. This rank alone.
    std::function<void(const std::function<bool(int plane)>& sides, bool beyond)> fill_beyond_walls;
};

class StageForcing {
public:
    virtual ~StageForcing() = default;
    /// Of implicit stages, before they are solved for: adds the pushes by forces of the last step to the velocity.
    /// Collective.
    virtual void hold(const FlowStage& stage) = 0;
    /// Of explicit stages, before bodies move on: notes what the flow would be at its end without them. Collective.
    virtual void meet(const FlowStage& stage) = 0;
    /// Changes velocities of this rank's cells; their ghosts are set afterwards. Behind meet() where the stage is
    /// explicit. Collective.
    virtual void apply(const FlowStage& stage) = 0;
    /// Of this rank's planes of cells, whether it changed some of one in the last stage.
    virtual bool changed(int plane) const = 0;
};

} // namespace skein
