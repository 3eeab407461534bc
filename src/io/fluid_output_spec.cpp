#include "io/fluid_output_spec.hpp"

namespace skein {

void FluidOutputSpec::fields(FieldVisitor& f) {
    f.visit({.name = "name",
             .unit = "",
             .text = "name in its files, fluid_<name>_<step>.h5 and fluid_<name>.xdmf",
             .required = true},
            name);
    f.choice({.name = "kind",
              .unit = "",
              .text = "slice: the plane of cells at a coordinate; box: all or part of the grid, as means over cubes of "
                      "cells; blocks: cubes of cells in which Q or vorticity exceeds a threshold",
              .required = true},
             kind, fluid_output_names);
    f.visit({.name = "every", .unit = "s", .text = "interval between frames", .required = true, .above = 0}, every);
    f.visit({.name = "fields",
             .unit = "",
             .text = "fields to write: any of \"velocity\", \"vorticity\", \"q\", \"pressure\"; default: all"},
            which);
    f.choice({.name = "precision", .unit = "", .text = "precision of the numbers in files"}, precision,
             precision_names);
    f.choice({.name = "across", .unit = "", .text = "normal direction of a slice"}, across, direction_names);
    f.visit({.name = "at", .unit = "m", .text = "coordinate of a slice; it contains the cells cut by this plane"}, at);
    f.visit_optional(
        {.name = "lower",
         .unit = "m",
         .text = "lower corner of a box, moved to the nearest corner of cells; default: corner of the fluid"},
        lower);
    f.visit_optional(
        {.name = "upper", .unit = "m", .text = "upper corner of a box, moved likewise; default: corner of the fluid"},
        upper);
    f.visit({.name = "average",
             .unit = "-",
             .text = "edge of the averaging cubes of a box, in cells; the cubes must fill the box; 1: all cells",
             .at_least = 1,
             .at_most = 256},
            average);
    f.choice({.name = "criterion", .unit = "", .text = "field compared with the threshold of blocks, by magnitude"},
             criterion, block_criterion_names);
    f.visit({.name = "threshold",
             .unit = "1/s^2 or 1/s",
             .text = "a block is written if one of its cells exceeds this value: 1/s^2 for q, 1/s for vorticity",
             .at_least = 0},
            threshold);
    f.visit({.name = "edge", .unit = "-", .text = "edge of a block, in cells", .at_least = 4, .at_most = 64}, edge);
}

} // namespace skein
