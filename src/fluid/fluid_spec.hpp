// What a scene says about a fluid.
#pragma once

#include "fluid/flow.hpp"
#include "skein/core/fields.hpp"

#include <optional>
#include <string>
#include <vector>

namespace skein {

/// Across which direction the no-slip walls move.
enum class MovingWalls { automatic, x, y, z };
inline constexpr std::string_view moving_walls_names[] = {"auto", "x", "y", "z"};

/// [fluid]: a box of fluid around everything.
struct FluidSpec {
    std::vector<long> cells;
    double spacing = 0;                              ///< edge of a cell, m
    Vec3d lower{0, 0, 0};                            ///< corner of the box, m
    std::optional<Vec3d> margin_lower, margin_upper; ///< of a box that is fitted to the rods at the start, m
    bool follows_rods = false;                       ///< the box moves along x with them
    double density = 0;                              ///< kg/m^3
    double viscosity = 0;                            ///< dynamic, Pa s
    FluidBoundary along_x = FluidBoundary::periodic, along_y = FluidBoundary::periodic,
                  along_z = FluidBoundary::periodic;
    Vec3d inflow{0, 0, 0}; ///< m/s
    InflowProfile inflow_profile = InflowProfile::uniform;
    Vec3d acceleration{0, 0, 0};        ///< m/s^2
    Vec3d lower_wall_velocity{0, 0, 0}; ///< m/s
    Vec3d upper_wall_velocity{0, 0, 0}; ///< m/s
    MovingWalls moving_walls = MovingWalls::automatic;
    double frequency = 0; ///< of walls and acceleration, Hz; 0: steady
    std::vector<std::string>
        velocity_formula; ///< at the start, m/s; none: at rest, or the inflow where something flows through
    FlowScheme scheme = FlowScheme::rk3;
    double courant = 0.5;       ///< largest sum of Courant numbers of a step
    double expected_speed = 0;  ///< m/s, for plans and, with rods, for steps; 0: from what the scene says
    double largest_slip = 0.02; ///< over the largest speed, of rods that feel the fluid; 0: steps do not follow from it
    PressureMethod pressure = PressureMethod::direct;
    ColumnExchange pressure_exchange = ColumnExchange::transposes;
    double pressure_tolerance = 1e-10; ///< residual of multigrid over the right side
    long ranks_across = 0;             ///< that share the rows of a slab; 0: as few as the planes allow
    std::string ranks_across_at;       ///< where the scene says so, "file:line"

    bool fitted() const { return margin_lower || margin_upper; }
    FlowConstants constants() const;
    std::array<FluidBoundary, 3> boundaries() const { return {along_x, along_y, along_z}; }
    /// Across which walls move: as moving_walls says, or else the one direction across which they are no_slip; -1:
    /// there is no such.
    int moving_direction() const;
    void fields(FieldVisitor& f);
};

} // namespace skein
