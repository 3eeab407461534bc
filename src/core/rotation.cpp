#include "core/rotation.hpp"

#include <cmath>

namespace skein {

namespace detail {

namespace {
/// theta/sin(theta/2), and g of theory.md (7).
struct LogFactors {
    double angle_over_half_sine, jacobian;
};

/// Factors from sin(theta/2) and cos(theta/2), neither negative.
LogFactors log_factors(double half_sine, double half_cosine) {
    const double versine = 1 - half_cosine;
    if (versine <= small_versine)
        return {polynomial(Pack<1>(versine), angle_over_half_sine)[0], polynomial(Pack<1>(versine), log_jacobian)[0]};
    const double half = std::atan2(half_sine, half_cosine);
    return {2 * half / half_sine, (1 - half * half_cosine / half_sine) / (4 * half * half)};
}

} // namespace

template <int W> void large_half_angle(const Pack<W>& squared, HalfAngle<Pack<W>>& f) {
    for (int i = 0; i < W; ++i)
        if (squared[i] > small_half_angle_squared) {
            const double t = std::sqrt(squared[i]);
            f.cosine.set(i, std::cos(t));
            f.sine_over.set(i, std::sin(t) / t);
        }
}

template <int W>
void large_relative_rotation(const Pack<W>& half_cosine, const Vec3<Pack<W>>& half_sine, RelativeRotation<Pack<W>>& r) {
    for (int i = 0; i < W; ++i) {
        if (!(1 - half_cosine[i] > small_versine)) continue;
        // A frame has two signs; the one with the smaller turn is taken.
        const Vec3d sine = lane(half_sine, i);
        const LogFactors f = log_factors(norm(sine), std::abs(half_cosine[i]));
        set_lane(r.log, i, std::copysign(f.angle_over_half_sine, half_cosine[i]) * sine);
        r.jacobian.set(i, f.jacobian);
    }
}

#define SKEIN_LARGE_ROTATIONS(W)                                                                                       \
    template void large_half_angle(const Pack<W>&, HalfAngle<Pack<W>>&);                                               \
    template void large_relative_rotation(const Pack<W>&, const Vec3<Pack<W>>&, RelativeRotation<Pack<W>>&)
SKEIN_LARGE_ROTATIONS(1);
SKEIN_LARGE_ROTATIONS(2);
SKEIN_LARGE_ROTATIONS(4);
SKEIN_LARGE_ROTATIONS(8);

} // namespace detail
} // namespace skein
