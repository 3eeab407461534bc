// Numbers of a scene for the forcing at markers.
#pragma once

#include "immersion/delta.hpp"

namespace skein {

struct ForcingNumbers {
    DeltaKind delta = DeltaKind::three_point;
    int sweeps = 2;  ///< at most
    double slip = 0; ///< m/s; sweeps end below it
    /// Springs and dampers in place of sweeps, by area and density of the fluid, 1/s^2 and 1/s times m; 0: sweeps.
    double stiffness = 0, damping = 0;
    bool two_way = false;           ///< rods feel the fluid: sweeps are scaled by sweep_shares()
    double kinematic_viscosity = 0; ///< m^2/s, at sharp surfaces

    bool penalty() const { return stiffness > 0 || damping > 0; }
};

} // namespace skein
