// Pressure of a flow at the end of a step, from the pressure in the middle of the step. theory.md (77a)
#pragma once

#include "fluid/flow.hpp"

#include <optional>
#include <span>

namespace skein {

/// Extrapolation of a flow solver's pressure in time.
class PressureInTime {
public:
    virtual ~PressureInTime() = default;

    /// Gain of FlowSolver::pressure() in the last step, and the factor by which it extrapolates the pressure to
    /// FlowSolver::time(). It is valid between steps, without ghosts.
    struct Gain {
        std::span<const double> field;
        double times; ///< equal on all ranks; 0: no extrapolation
    };
    virtual Gain pressure_gain() const = 0;
    /// Enables pressure_gain(), whose factor is 0 otherwise.
    virtual void keep_pressure_gain() = 0;
    /// Time of the pressure, s; absent if bodies began to act in the last step.
    virtual std::optional<double> pressure_time() const = 0;
    /// Sets the time after FlowSolver::refresh(), and the factor of the gain to 0.
    virtual void set_pressure_time(std::optional<double> time) = 0;
    /// Sets the factor of the gain, and returns its field without ghosts for writing. It must be enabled.
    virtual std::span<double> restore_pressure_gain(double times) = 0;
};

inline PressureInTime& pressure_in_time(FlowSolver& flow) { return dynamic_cast<PressureInTime&>(flow); }
inline const PressureInTime& pressure_in_time(const FlowSolver& flow) {
    return dynamic_cast<const PressureInTime&>(flow);
}

} // namespace skein
