#include "core/rotation.hpp"

#include <cmath>

namespace skein::detail {

RotationFactors<double> rotation_factors_libm(double angle_squared) {
    const double t = std::sqrt(angle_squared), half_sine = std::sin(0.5 * t);
    return {std::sin(t) / t, 2 * half_sine * half_sine / angle_squared};
}

double half_angle_over_sine_libm(double sine, double trace) {
    return std::atan2(sine, 0.5 * (trace - 1)) / (2 * sine);
}

double log_jacobian_libm(double angle_squared) {
    const double half = 0.5 * std::sqrt(angle_squared);
    return (1 - half / std::tan(half)) / angle_squared;
}

} // namespace skein::detail
