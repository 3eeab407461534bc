// Slowest small motions of one rod about its rest shape, with the masses, stiffness and supports of the scheme.
// theory.md, end of section 9
#pragma once

#include "skein/rod/rod_group.hpp"

#include <vector>

namespace skein {

struct RodMode {
    double eigenvalue = 0;   ///< w^2, 1/s^2
    std::vector<Vec3d> turn; ///< of the elements, body; kinetic energy 1/2 at unit rate, so in rad/(kg^1/2 m)
};

/// Slowest modes, rigid motions left out, in which sections turn mostly about d1 and d2: lowest first, at most `most`.
/// The start of `rod` must be its rest shape. Thin rods count as no thinner than bending by shear is below 1e-5.
std::vector<RodMode> slowest_bending(const RodGroup& rod, std::size_t most);

} // namespace skein
