// What bodies do to a fluid within a stage of its step.
#pragma once

#include <array>
#include <functional>

namespace skein {

/// Viscosity that a stage solves for, as `scratch` of the stage feels it.
class ImplicitViscosity {
public:
    virtual ~ImplicitViscosity() = default;
    /// Sets it to 0.
    virtual void clear() = 0;
    /// From changes of velocity without viscosity, ghosts aside, to the changes at the end of the stage, ghosts beyond walls among
    /// them. Collective.
    virtual void diffuse() = 0;
    /// Adds so many times it to the velocity.
    virtual void add(double factor) = 0;
};

/// A flow after a stage without its bodies and before its projection.
struct FlowStage {
    std::array<double*, 3> velocity; ///< of this rank, as FlowSolver::layout() has them
    std::array<double*, 3> scratch;  ///< as large, of no meaning
    double time;                     ///< at the end of the stage, s
    double dt;                       ///< of the stage, s
    ImplicitViscosity* implicit;     ///< null: viscosity is explicit
    /// Sets ghosts of velocities beyond walls: across x and y in planes of this rank for which `sides` says so, and with `beyond`
    /// across z. This rank alone.
    std::function<void(const std::function<bool(int plane)>& sides, bool beyond)> fill_beyond_walls;
};

class StageForcing {
public:
    virtual ~StageForcing() = default;
    /// Of stages with implicit viscosity, before that is solved for: adds to the velocity what the forces of the last step do
    /// without it. Collective.
    virtual void hold(const FlowStage& stage) = 0;
    /// Changes velocities of this rank's cells; their ghosts are set afterwards. Collective.
    virtual void apply(const FlowStage& stage) = 0;
    /// Of this rank's planes of cells, whether it changed some of one in the last stage.
    virtual bool changed(int plane) const = 0;
};

} // namespace skein
