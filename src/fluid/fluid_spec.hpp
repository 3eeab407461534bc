// What a scene says about a fluid.
#pragma once

#include "fluid/flow.hpp"
#include "skein/core/fields.hpp"

#include <string>
#include <vector>

namespace skein {

/// [fluid]: a box of fluid around everything.
struct FluidSpec {
    std::vector<long> cells;
    double spacing = 0;   ///< edge of a cell, m
    Vec3d lower{0, 0, 0}; ///< corner of the box, m
    double density = 0;   ///< kg/m^3
    double viscosity = 0; ///< dynamic, Pa s
    FluidBoundary along_x = FluidBoundary::periodic, along_y = FluidBoundary::periodic, along_z = FluidBoundary::periodic;
    Vec3d inflow{0, 0, 0};                     ///< m/s
    Vec3d acceleration{0, 0, 0};               ///< m/s^2
    std::vector<std::string> velocity_formula; ///< at the start, m/s; none: at rest, or the inflow where something flows through
    FlowScheme scheme = FlowScheme::rk3;
    double courant = 0.5;      ///< largest sum of Courant numbers of a step
    double expected_speed = 0; ///< m/s, for plans alone; 0: from what the scene says
    PressureMethod pressure = PressureMethod::direct;
    double pressure_tolerance = 1e-10; ///< residual of multigrid over the right side

    FlowConstants constants() const;
    void fields(FieldVisitor& f);
};

} // namespace skein
