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
             .text = "three formulas of x, y and z: velocity at the start, of which the part without divergence is "
                     "taken; empty: at rest, "
                     "or the inflow"},
            velocity_formula);
    scheme_fields(f);
    pressure_fields(f);
}

void FluidSpec::box_fields(FieldVisitor& f) {
    f.visit({.name = "cells",
             .unit = "-",
             .text = "numbers of cells along x, y and z: products of 2, 3, 5 and 7 where the pressure is direct; "
                     "needed but with "
                     "margins"},
            cells);
    f.visit({.name = "spacing", .unit = "m", .text = "edge of a cell, which is a cube", .required = true, .above = 0},
            spacing);
    f.visit({.name = "lower", .unit = "m", .text = "lower corner of the box"}, lower);
    f.visit_optional(
        {.name = "margin_lower",
         .unit = "m",
         .text = "instead of `cells` and `lower`: the box reaches so far beyond the axes of rods at the start, as if "
                 "they were straight, towards lower x, y and z; what smooth numbers of cells add is shared by both "
                 "sides"},
        margin_lower);
    f.visit_optional(
        {.name = "margin_upper", .unit = "m", .text = "the same towards upper x, y and z; absent: as the other one"},
        margin_upper);
    f.visit({.name = "follows_rods",
             .unit = "",
             .text = "the box moves along x with the middle of all rods, by whole cells: fluid at rest comes in on one "
                     "side, and "
                     "what leaves on the other is gone. Needs along_x = \"free_slip\" or \"no_slip\""},
            follows_rods);
}

void FluidSpec::boundary_fields(FieldVisitor& f) {
    const auto boundary = [&](std::string_view name, std::string_view text, FluidBoundary& value) {
        f.choice({.name = name, .unit = "", .text = text}, value, fluid_boundary_names);
    };
    boundary("along_x",
             "what bounds the box across x: through, in at the lower face and out at the upper one, is for x alone",
             along_x);
    boundary("along_y", "the same across y", along_y);
    boundary("along_z", "the same across z", along_z);
    f.visit({.name = "inflow", .unit = "m/s", .text = "velocity at the lower face where the fluid flows through"},
            inflow);
    f.choice({.name = "inflow_profile",
              .unit = "",
              .text = "parabolic: that of a channel between no_slip walls across y or z, whose mean is `inflow`; "
                      "between walls across both "
                      "the product of two parabolas, 7 % faster in the middle of a square than the flow of a duct, "
                      "which forms on "
                      "the way"},
             inflow_profile, inflow_profile_names);
}

void FluidSpec::drive_fields(FieldVisitor& f) {
    f.visit({.name = "acceleration", .unit = "m/s^2", .text = "of all of the fluid, by what drives it"}, acceleration);
    f.visit({.name = "lower_wall_velocity",
             .unit = "m/s",
             .text = "of the lower no_slip wall, along itself; see moving_walls"},
            lower_wall_velocity);
    f.visit({.name = "upper_wall_velocity", .unit = "m/s", .text = "of the upper one"}, upper_wall_velocity);
    f.choice({.name = "moving_walls",
              .unit = "",
              .text = "direction across which the walls with these velocities lie, all others rest; auto: that of the "
                      "no_slip walls, "
                      "where they are of one direction"},
             moving_walls, moving_walls_names);
    f.visit({.name = "frequency",
             .unit = "Hz",
             .text = "acceleration and velocities of walls are multiplied by cos(2 pi frequency t), and a step is at "
                     "most a fortieth of "
                     "a period; 0: they are steady",
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
    f.visit(
        {.name = "courant",
         .unit = "-",
         .text =
             "largest sum over directions of velocity times step over spacing; longer steps of the scene are divided",
         .above = 0,
         .at_most = 1.5},
        courant);
    f.visit({.name = "expected_speed",
             .unit = "m/s",
             .text = "speed that plans predict the number of steps from, and with rods take the longest step of the "
                     "fluid from. 0: "
                     "the largest of inflow, walls, an acceleration that swings, velocity at the start, obstacles and "
                     "what rods are "
                     "bound to do: by velocities at the start, moved ends, weight, muscles and rest curvature",
             .at_least = 0},
            expected_speed);
    f.visit({.name = "largest_slip",
             .unit = "-",
             .text = "of rods that feel the fluid by direct forcing: where the difference of velocities at markers is "
                     "above this share "
                     "of the largest speed, steps of the fluid become shorter, down to 15 steps of rods (1 of "
                     "one-stage schemes); 0: "
                     "they do not",
             .at_least = 0},
            largest_slip);
}

void FluidSpec::pressure_fields(FieldVisitor& f) {
    f.choice({.name = "pressure",
              .unit = "",
              .text = "direct: Poisson's equation by transforms; multigrid: by iterations, for any numbers of cells, "
                      "at many times "
                      "the cost, with bits that depend on the number of ranks; needs PETSc"},
             pressure, pressure_method_names);
    f.choice({.name = "pressure_exchange",
              .unit = "",
              .text = "what ranks exchange in a direct solve: transposes: coefficients, which change ranks and come "
                      "back, with the "
                      "same bits on any ranks; interfaces: numbers at interfaces of slabs alone, far fewer, with "
                      "results that agree "
                      "to about 1e-12 on other numbers of ranks, not in bits"},
             pressure_exchange, column_exchange_names);
    f.visit({.name = "pressure_tolerance",
             .unit = "-",
             .text = "residual at which multigrid is done, over the right side",
             .at_least = 1e-14,
             .at_most = 1e-2},
            pressure_tolerance);
    f.visit(
        {.name = "ranks_across",
         .unit = "-",
         .text =
             "ranks that share the rows of a slab of planes along y: a divisor of the number of ranks, all of which "
             "then "
             "make fewer slabs; a rank needs two rows, and two planes. 0: as few as the planes allow. With transposes "
             "results do not depend on it, and it may change at a restart",
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
