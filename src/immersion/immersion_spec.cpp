#include "immersion/immersion_spec.hpp"

namespace skein {

namespace {

void visit_surfaces(FieldVisitor& f, ImmersionSpec& spec) {
    f.choice({.name = "body_surface",
              .unit = "",
              .text = "rigid bodies act on the fluid by markers, spread over three cells, or by sharp surfaces as "
                      "obstacles do; bodies with a part thinner than two cells have markers in any case"},
             spec.body_surface, surface_names);
    f.choice({.name = "rod_surface",
              .unit = "",
              .text = "rods act on the fluid by markers, or by sharp surfaces if some part of them is two cells thick; "
                      "parts thinner than a cell have markers in any case"},
             spec.rod_surface, surface_names);
}

} // namespace

void ImmersionSpec::fields(FieldVisitor& f) {
    f.choice({.name = "delta",
              .unit = "",
              .text = "discrete delta function: three or four grid points near a marker in each direction"},
             delta, delta_names);
    f.choice({.name = "forcing",
              .unit = "",
              .text = "direct: velocities near markers are set in each stage; penalty: springs and dampers at markers "
                      "couple fluid and bodies, for comparison with such methods"},
             forcing, forcing_names);
    f.visit({.name = "penalty_stiffness",
             .unit = "N/m^3",
             .text = "penalty: stiffness of the springs per area of the surface; the area of a marker is the square of "
                     "the spacing",
             .at_least = 0},
            penalty_stiffness);
    f.visit({.name = "penalty_damping",
             .unit = "N s/m^3",
             .text = "penalty: damping of the dampers per area of the surface",
             .at_least = 0},
            penalty_damping);
    f.visit({.name = "sweeps",
             .unit = "-",
             .text = "largest number of velocity corrections in a stage; with scheme crank_nicolson each solves for "
                     "viscosity again. With two-way coupling, all corrections together change a slip by at most three "
                     "times the change of the first one, for stability",
             .at_least = 1,
             .at_most = 20},
            sweeps);
    f.visit({.name = "slip",
             .unit = "m/s",
             .text = "corrections stop when the slip between fluid and bodies is below this; 0: all corrections",
             .at_least = 0},
            slip);
    f.visit(
        {.name = "retraction",
         .unit = "-",
         .text = "inward offset of the markers of rods and rigid bodies, in cells (immersed bodies appear too large)",
         .at_least = 0,
         .at_most = 2},
        retraction);
    visit_surfaces(f, *this);
    f.choice({.name = "coupling",
              .unit = "",
              .text =
                  "two_way: rods, rigid bodies and fluid act on each other; one_way: rods and rigid bodies move the "
                  "fluid, but it does not act on them"},
             coupling, rod_coupling_names);
    f.visit(
        {.name = "inner_inertia",
         .unit = "",
         .text =
             "with two-way coupling; true: the fluid inside rods and rigid bodies moves with them and carries its "
             "own inertia; false: they carry their own inertia and the inertia of the fluid inside, as if they were "
             "heavier, for comparison with such methods"},
        inner_inertia);
}

} // namespace skein
