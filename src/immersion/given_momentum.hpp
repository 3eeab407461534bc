// Momentum that a body gives the fluid.
#pragma once

#include "skein/core/vec3.hpp"

namespace skein {

/// Momentum over density, m^4/s, and its moment about the body's origin, m^5/s.
struct GivenMomentum {
    Vec3d linear{0, 0, 0}, angular{0, 0, 0};

    GivenMomentum& operator+=(const GivenMomentum& other) {
        linear += other.linear;
        angular += other.angular;
        return *this;
    }
};

} // namespace skein
