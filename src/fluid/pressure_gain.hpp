// The pressure of a flow at the end of a step, from that of the middle of the step. theory.md (77a)
#pragma once

#include "fluid/flow.hpp"

#include <optional>
#include <span>

namespace skein {

/// Times of a flow solver's pressures.
class PressureInTime {
public:
    virtual ~PressureInTime() = default;

    /// Gain of FlowSolver::pressure() in the last step, and how many times this makes it the pressure of
    /// FlowSolver::time(). Only between steps; ghosts have no meaning.
    struct Gain {
        std::span<const double> field;
        double times; ///< the same on all ranks; 0: the pressure is the best that is known
    };
    virtual Gain pressure_gain() const = 0;
    /// pressure_gain() will be asked for from now on; without this it is 0 times.
    virtual void keep_pressure_gain() = 0;
    /// The time to which the pressure belongs, s; none where bodies began to act in the last step.
    virtual std::optional<double> pressure_time() const = 0;
    /// After FlowSolver::refresh(); the gain is 0 times from here on.
    virtual void set_pressure_time(std::optional<double> time) = 0;
    /// The gain is that of another run's last step, so many times, once its field is written, ghosts aside. Where it is
    /// kept.
    virtual std::span<double> restore_pressure_gain(double times) = 0;
};

inline PressureInTime& pressure_in_time(FlowSolver& flow) { return dynamic_cast<PressureInTime&>(flow); }
inline const PressureInTime& pressure_in_time(const FlowSolver& flow) {
    return dynamic_cast<const PressureInTime&>(flow);
}

} // namespace skein
