#include "immersion/immersion_spec.hpp"

namespace skein {

void ImmersionSpec::fields(FieldVisitor& f) {
    f.choice(
        {.name = "delta", .unit = "", .text = "weights of the grid points near a marker: of three or four along each direction"},
        delta, delta_names);
    f.visit({.name = "sweeps",
             .unit = "-",
             .text = "corrections of velocities in a stage, at most; of scheme crank_nicolson each solves for viscosity once more",
             .at_least = 1,
             .at_most = 20},
            sweeps);
    f.visit({.name = "slip",
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
    f.choice({.name = "coupling",
              .unit = "",
              .text = "two_way: rods move the fluid and feel it; one_way: they move as if there were none, and move it"},
             coupling, rod_coupling_names);
}

} // namespace skein
