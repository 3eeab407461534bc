// Onset of loads that change with time: 0 until the onset, then from 0 to 1 along a line or half a cosine wave.
//   x = min(1, (t - t0)/T_r)      r = x,   or   r = (1 - cos pi x)/2
#pragma once

#include "skein/core/fields.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

namespace skein {

enum class RampShape { linear, cosine };
inline constexpr std::string_view ramp_shape_names[] = {"linear", "cosine"};

/// Share that rises over `duration` from time 0 on; 1 throughout for duration 0.
inline double ramp_at(double time, double duration, RampShape shape = RampShape::linear) {
    if (time < 0) return 0;
    const double x = duration > 0 ? std::min(1.0, time / duration) : 1.0;
    return shape == RampShape::linear ? x : 0.5 * (1 - std::cos(std::numbers::pi * x));
}

struct Ramp {
    double duration = 0; ///< T_r, s
    double onset = 0;    ///< t0, s
    RampShape shape = RampShape::linear;

    /// Keys `ramp`, `onset` and `ramp_shape` of a load.
    void fields(FieldVisitor& f) {
        f.visit({.name = "ramp", .unit = "s", .text = "time of the rise from 0", .at_least = 0}, duration);
        f.visit({.name = "onset", .unit = "s", .text = "time at which the load begins", .at_least = 0}, onset);
        f.choice({.name = "ramp_shape", .text = "shape of the rise: linear, or half a cosine wave, which is smooth"},
                 shape, ramp_shape_names);
    }
    double at(double time) const { return ramp_at(time - onset, duration, shape); }
};

} // namespace skein
