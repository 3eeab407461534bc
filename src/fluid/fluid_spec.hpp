// Settings of a scene for a fluid.
#pragma once

#include "fluid/flow.hpp"
#include "skein/core/fields.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace skein {

/// Direction across which no-slip walls move.
enum class MovingWalls { automatic, x, y, z };
inline constexpr std::string_view moving_walls_names[] = {"auto", "x", "y", "z"};

/// [fluid]: a box of fluid around everything.
struct FluidSpec {
    static constexpr bool presence_decides = false; ///< the meaning of a state
    static constexpr bool stands_alone = true;      ///< as a scene without rods

    std::vector<long> cells;
    double spacing = 0;                              ///< edge of a cell, m
    Vec3d lower{0, 0, 0};                            ///< corner of the box, m
    std::optional<Vec3d> margin_lower, margin_upper; ///< margins of a box fitted to the rods at the start, m
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
    double frequency = 0; ///< frequency of walls and acceleration, Hz; 0: steady
    /// Velocity at the start, m/s; empty: rest, or the inflow.
    std::vector<std::string> velocity_formula;
    FlowScheme scheme = FlowScheme::rk3;
    double courant = 0.5;       ///< largest sum of Courant numbers of a step
    double expected_speed = 0;  ///< m/s, for plans and, with rods, for steps; 0: estimated from the scene
    double largest_slip = 0.02; ///< slip of two-way rods over the largest speed that shortens steps; 0: none does
    PressureMethod pressure = PressureMethod::direct;
    ColumnExchange pressure_exchange = ColumnExchange::transposes;
    double pressure_tolerance = 1e-10; ///< residual of multigrid over the right side
    long ranks_across = 0;             ///< ranks that share the rows of a slab; 0: as few as the planes allow
    std::map<std::string, std::string> key_source; ///< file:line by key that the scene gives, for messages

    bool fitted() const { return margin_lower || margin_upper; }
    FlowConstants constants() const;
    std::array<FluidBoundary, 3> boundaries() const { return {along_x, along_y, along_z}; }
    /// Direction across which walls move: moving_walls, or the only direction with no_slip walls; -1: none.
    int moving_direction() const;
    void fields(FieldVisitor& f);

private:
    /// Keys by topic, which fields() visits in this order.
    void box_fields(FieldVisitor& f);
    void boundary_fields(FieldVisitor& f);
    void drive_fields(FieldVisitor& f);
    void scheme_fields(FieldVisitor& f);
    void pressure_fields(FieldVisitor& f);
};

} // namespace skein
