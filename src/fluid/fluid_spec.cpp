#include "fluid/fluid_spec.hpp"

#include "skein/core/index.hpp"

#include <algorithm>

namespace skein {

void FluidSpec::fields(FieldVisitor& f) {
    box_fields(f);
    f.visit({.name = "density", .unit = "kg/m^3", .text = "density", .required = true, .above = 0}, density);
    f.visit({.name = "viscosity", .unit = "Pa s", .text = "dynamic viscosity", .required = true, .at_least = 0},
            viscosity);
    boundary_fields(f);
    drive_fields(f);
    f.visit({.name = "velocity_formula",
             .unit = "m/s",
             .text = "three formulas of x, y and z: velocity at the start; its divergence-free part is used; empty: "
                     "fluid at rest, or the inflow"},
            velocity_formula);
    scheme_fields(f);
    pressure_fields(f);
}

void FluidSpec::box_fields(FieldVisitor& f) {
    f.visit({.name = "cells",
             .unit = "-",
             .text = "numbers of cells along x, y and z; with direct pressure, products of 2, 3, 5 and 7; required "
                     "unless margins are given"},
            cells);
    f.visit({.name = "spacing", .unit = "m", .text = "edge of a cell, which is a cube", .required = true, .above = 0},
            spacing);
    f.visit({.name = "lower", .unit = "m", .text = "lower corner of the box"}, lower);
    f.visit_optional(
        {.name = "margin_lower",
         .unit = "m",
         .text =
             "margins between the axes of rods at the start, taken as straight, and the box, towards lower x, y and z; "
             "replaces `cells` and `lower`. If the numbers of cells are rounded up, both sides share the addition"},
        margin_lower);
    f.visit_optional(
        {.name = "margin_upper", .unit = "m", .text = "margins towards upper x, y and z; default: `margin_lower`"},
        margin_upper);
    f.visit(
        {.name = "follows_rods",
         .unit = "",
         .text =
             "true: the box moves along x with the middle of all rods, by whole cells. Fluid at rest enters on one "
             "side, and the fluid that leaves on the other is discarded. Needs along_x = \"free_slip\" or \"no_slip\""},
        follows_rods);
}

void FluidSpec::boundary_fields(FieldVisitor& f) {
    const auto boundary = [&](std::string_view name, std::string_view text, FluidBoundary& value) {
        f.choice({.name = name, .unit = "", .text = text}, value, fluid_boundary_names);
    };
    boundary("along_x",
             "boundary condition at the faces normal to x; through (only x): inflow at the lower face, outflow at the "
             "upper face",
             along_x);
    boundary("along_y", "boundary condition at the faces normal to y", along_y);
    boundary("along_z", "boundary condition at the faces normal to z", along_z);
    f.visit({.name = "inflow", .unit = "m/s", .text = "with \"through\": velocity at the lower face"}, inflow);
    f.choice({.name = "inflow_profile",
              .unit = "",
              .text = "parabolic: profile of a channel between no_slip walls normal to y or z, with the mean `inflow`. "
                      "Between walls in both directions it is the product of two parabolas. In the middle of a square "
                      "this is 7 % faster than the flow of a duct, which develops downstream"},
             inflow_profile, inflow_profile_names);
}

void FluidSpec::drive_fields(FieldVisitor& f) {
    f.visit({.name = "acceleration", .unit = "m/s^2", .text = "acceleration of the fluid by a uniform driving force"},
            acceleration);
    f.visit({.name = "lower_wall_velocity",
             .unit = "m/s",
             .text = "velocity of the lower no_slip wall, in its plane; see moving_walls"},
            lower_wall_velocity);
    f.visit({.name = "upper_wall_velocity", .unit = "m/s", .text = "velocity of the upper no_slip wall, in its plane"},
            upper_wall_velocity);
    f.choice({.name = "moving_walls",
              .unit = "",
              .text = "normal direction of the walls with these velocities; other walls are at rest; auto: direction "
                      "of the no_slip walls, if there is only one"},
             moving_walls, moving_walls_names);
    f.visit({.name = "frequency",
             .unit = "Hz",
             .text = "frequency f of a factor cos(2 pi f t) on the acceleration and the velocities of walls; a step is "
                     "at most a fortieth of a period; 0: they are steady",
             .at_least = 0},
            frequency);
}

void FluidSpec::scheme_fields(FieldVisitor& f) {
    f.choice({.name = "scheme",
              .unit = "",
              .text =
                  "rk3: three stages and one projection; rk3_projected: a projection in every stage, for comparison; "
                  "adams_bashforth: one stage, for short steps; crank_nicolson: one stage with implicit viscosity, "
                  "which does "
                  "not limit the "
                  "step, for low Reynolds numbers"},
             scheme, flow_scheme_names);
    f.visit({.name = "courant",
             .unit = "-",
             .text = "largest Courant number: sum over directions of velocity times step over spacing; a longer step "
                     "of the scene is divided. Schemes adams_bashforth and crank_nicolson take less, 0.1 at least, in "
                     "fluids of low viscosity",
             .above = 0,
             .at_most = 1.5},
            courant);
    f.visit(
        {.name = "expected_speed",
         .unit = "m/s",
         .text =
             "largest fluid speed expected; predicts the number of steps and, with rods, sets the fluid step. 0: "
             "largest of inflow, walls, oscillating acceleration, velocity at the start, obstacles, and the expected "
             "speed of rods (from velocities at the start, moved ends, weight, muscles and rest curvature)",
         .at_least = 0},
        expected_speed);
    f.visit({.name = "largest_slip",
             .unit = "-",
             .text = "largest slip over the largest speed, for two-way coupling by direct forcing. If the slip at "
                     "markers is larger, the fluid step becomes shorter, down to 15 steps of the rods (1 with "
                     "one-stage schemes); 0: no limit",
             .at_least = 0},
            largest_slip);
}

void FluidSpec::pressure_fields(FieldVisitor& f) {
    f.choice({.name = "pressure",
              .unit = "",
              .text = "solver of the pressure; direct: transforms; multigrid: iterations with PETSc, for any numbers "
                      "of cells; it costs many times more, and its bits depend on the number of ranks"},
             pressure, pressure_method_names);
    f.choice({.name = "pressure_exchange",
              .unit = "",
              .text = "messages of a direct solve; transposes: all coefficients, forth and back, with the same bits on "
                      "any number of ranks; interfaces: only the numbers at interfaces of slabs, far fewer; results on "
                      "other numbers of ranks agree to about 1e-12, not in bits"},
             pressure_exchange, column_exchange_names);
    f.visit({.name = "pressure_tolerance",
             .unit = "-",
             .text = "relative residual at which multigrid stops",
             .at_least = 1e-14,
             .at_most = 1e-2},
            pressure_tolerance);
    f.visit({.name = "ranks_across",
             .unit = "-",
             .text = "number of ranks that share the rows of a slab of planes along y, a divisor of the number of "
                     "ranks. A larger number makes fewer slabs; a rank needs two rows and two planes. 0: as few as the "
                     "planes allow. With transposes results do not depend on it, and it may change at a restart",
             .at_least = 0},
            ranks_across);
}

int FluidSpec::moving_direction() const {
    if (moving_walls != MovingWalls::automatic)
        return static_cast<int>(moving_walls) - static_cast<int>(MovingWalls::x);
    const std::array bounds = boundaries();
    if (std::count(bounds.begin(), bounds.end(), FluidBoundary::no_slip) != 1) return -1;
    return static_cast<int>(std::find(bounds.begin(), bounds.end(), FluidBoundary::no_slip) - bounds.begin());
}

FlowConstants FluidSpec::constants() const {
    FlowConstants c;
    for (std::size_t d = 0; d < 3; ++d) c.grid.cells[d] = static_cast<int>(cells[d]);
    c.grid.h = spacing;
    c.grid.lower = lower;
    c.grid.boundary = boundaries();
    c.density = density;
    c.kinematic_viscosity = viscosity / density;
    c.inflow = inflow;
    c.inflow_profile = inflow_profile;
    c.acceleration = acceleration;
    if (const int d = moving_direction(); d >= 0) nth(c.wall_velocity, d) = {lower_wall_velocity, upper_wall_velocity};
    c.frequency = frequency;
    c.scheme = scheme;
    c.pressure = pressure;
    c.exchange = pressure_exchange;
    c.pressure_tolerance = pressure_tolerance;
    c.ranks_across = static_cast<int>(ranks_across);
    return c;
}

} // namespace skein
