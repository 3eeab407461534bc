#include "immersion/immersion_spec.hpp"

namespace skein {

void ImmersionSpec::fields(FieldVisitor& f) {
    f.choice({.name = "delta",
              .unit = "",
              .text = "weights of the grid points near a marker: of three or four along each direction"},
             delta, delta_names);
    f.choice({.name = "forcing",
              .unit = "",
              .text = "direct: velocities near markers are set in each stage; penalty: springs and dampers at markers "
                      "pull fluid and "
                      "bodies together, for comparison with methods that do so"},
             forcing, forcing_names);
    f.visit({.name = "penalty_stiffness",
             .unit = "N/m^3",
             .text = "of springs, by area of the surface: a marker has the square of the spacing",
             .at_least = 0},
            penalty_stiffness);
    f.visit({.name = "penalty_damping", .unit = "N s/m^3", .text = "of dampers, the same", .at_least = 0},
            penalty_damping);
    f.visit(
        {.name = "sweeps",
         .unit = "-",
         .text =
             "corrections of velocities in a stage, at most; of scheme crank_nicolson each solves for viscosity once "
             "more. Where "
             "rods feel the fluid all together change no slip by more than three times what the first one does: more "
             "would be unstable",
         .at_least = 1,
         .at_most = 20},
        sweeps);
    f.visit(
        {.name = "slip",
         .unit = "m/s",
         .text = "difference of velocities of fluid and bodies at which there are no more corrections; 0: all are made",
         .at_least = 0},
        slip);
    f.visit({.name = "retraction",
             .unit = "-",
             .text = "how far markers of rods lie within the surface, over the spacing of the grid",
             .at_least = 0,
             .at_most = 2},
            retraction);
    f.choice(
        {.name = "coupling",
         .unit = "",
         .text = "two_way: rods move the fluid and feel it; one_way: they move as if there were none, and move it"},
        coupling, rod_coupling_names);
    f.visit(
        {.name = "inner_inertia",
         .unit = "",
         .text =
             "of rods that feel the fluid: what is within them moves with them and bears its own inertia. false: they "
             "bear "
             "all of theirs, and that fluid besides, as if they were heavier: for comparison with methods that do so"},
        inner_inertia);
}

} // namespace skein
