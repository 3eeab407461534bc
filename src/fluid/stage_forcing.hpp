// Forcing of a fluid by bodies within a stage of its step.
#pragma once

#include <array>
#include <functional>

namespace skein {

/// Response of an implicit stage to pushes, in `scratch` of the stage.
class StageResponse {
public:
    virtual ~StageResponse() = default;
    /// Sets pushes to 0.
    virtual void clear() = 0;
    /// Turns pushes, m/s without viscosity and without ghosts, into changes of velocity at the end of the stage. These
    /// are viscous, free of divergence, and have ghosts. Collective.
    virtual void respond() = 0;
    /// Adds the changes, `times` over, to the velocity, and their pressure to the pressure.
    virtual void add(double times) = 0;
};

/// Flow after a stage without its bodies, before the projection if the stage is explicit.
struct FlowStage {
    std::array<double*, 3> velocity;    ///< fields of this rank in FlowSolver::layout()
    std::array<double*, 3> scratch;     ///< memory of the same size, at first with `begin`
    std::array<const double*, 3> begin; ///< in sample(): velocities at the begin of the stage
    double time;                        ///< end of the stage, s
    double dt;                          ///< length of the stage, s
    bool ends_step;                     ///< last stage of a step
    StageResponse* response;            ///< null: the stage is explicit, and pushes are changes of velocity
    /// Sets ghosts of velocities beyond walls: across x and y in the planes that `sides` selects, and across z with
    /// `beyond`. Not collective.
    std::function<void(const std::function<bool(int plane)>& sides, bool beyond)> fill_beyond_walls;
};

class StageForcing {
public:
    virtual ~StageForcing() = default;
    /// Implicit stages, before their solution: adds pushes by forces of the last step to the velocity. Collective.
    virtual void add_held_forces(const FlowStage& stage) = 0;
    /// Explicit stages, before bodies move: interpolates the flow at its end without bodies. Collective.
    virtual void sample(const FlowStage& stage) = 0;
    /// Changes velocities of this rank's cells, whose ghosts are set afterwards. It follows sample() in explicit
    /// stages. Collective.
    virtual void apply(const FlowStage& stage) = 0;
    /// True if the last stage changed cells of this plane of this rank.
    virtual bool changed(int plane) const = 0;
};

} // namespace skein
