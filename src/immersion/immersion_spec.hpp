// Settings of a scene for bodies in the fluid.
#pragma once

#include "immersion/forcing_numbers.hpp"
#include "immersion/obstacle.hpp"
#include "skein/core/fields.hpp"

#include <string_view>

namespace skein {

/// Coupling of rods and fluid.
enum class RodCoupling {
    two_way, ///< rods and fluid act on each other
    one_way  ///< rods move the fluid, but do not feel it
};
inline constexpr std::string_view rod_coupling_names[] = {"two_way", "one_way"};

/// Method that makes fluid and bodies move together.
enum class ForcingKind {
    direct, ///< direct setting of velocities
    penalty ///< springs and dampers
};
inline constexpr std::string_view forcing_names[] = {"direct", "penalty"};

/// [immersion]
struct ImmersionSpec {
    DeltaKind delta = DeltaKind::three_point;
    ForcingKind forcing = ForcingKind::direct;
    double penalty_stiffness = 0; ///< N/m^3
    double penalty_damping = 0;   ///< N s/m^3
    long sweeps = 2;
    double slip = 0;         ///< m/s
    double retraction = 0.4; ///< depth of markers in rods over the spacing of the grid
    RodCoupling coupling = RodCoupling::two_way;
    SurfaceKind body_surface = SurfaceKind::markers; ///< of rigid bodies
    SurfaceKind rod_surface = SurfaceKind::markers;
    bool inner_inertia = true; ///< fluid within rods bears its own inertia

    /// Numbers for a fluid of a density, kg/m^3.
    ForcingNumbers numbers(double density) const {
        return {delta, static_cast<int>(sweeps), slip, penalty_stiffness / density, penalty_damping / density};
    }
    void fields(FieldVisitor& f);
};

} // namespace skein
