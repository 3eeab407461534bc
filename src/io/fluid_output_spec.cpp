#include "io/fluid_output_spec.hpp"

namespace skein {

void FluidOutputSpec::fields(FieldVisitor& f) {
    f.visit({.name = "name",
             .unit = "",
             .text = "of its files, fluid_<name>_<step>.h5 and fluid_<name>.xdmf",
             .required = true},
            name);
    f.choice(
        {.name = "kind",
         .unit = "",
         .text =
             "slice: the plane of cells at a coordinate; box: a part of the grid or all of it, as means over cubes of "
             "cells; blocks: cubes of cells in which Q or vorticity exceeds a threshold somewhere",
         .required = true},
        kind, fluid_output_names);
    f.visit({.name = "every", .unit = "s", .text = "interval of frames", .required = true, .above = 0}, every);
    f.visit({.name = "fields",
             .unit = "",
             .text = "which are written: any of \"velocity\", \"vorticity\", \"q\", \"pressure\"; all where absent"},
            which);
    f.choice({.name = "precision", .unit = "", .text = "of the numbers in files"}, precision, precision_names);
    f.choice({.name = "across", .unit = "", .text = "direction that a slice is normal to"}, across, direction_names);
    f.visit({.name = "at",
             .unit = "m",
             .text = "coordinate of a slice: it has the cells that the plane there goes through"},
            at);
    f.visit_optional({.name = "lower",
                      .unit = "m",
                      .text = "lower corner of a box, moved to the nearest corner of cells; absent: of the fluid"},
                     lower);
    f.visit_optional({.name = "upper", .unit = "m", .text = "upper corner of a box, the same"}, upper);
    f.visit({.name = "average",
             .unit = "-",
             .text = "cells along an edge of the cubes that a box has means over; they must fill it. 1: all cells",
             .at_least = 1,
             .at_most = 256},
            average);
    f.choice({.name = "criterion", .unit = "", .text = "what is held against the threshold of blocks, by magnitude"},
             criterion, block_criterion_names);
    f.visit({.name = "threshold",
             .unit = "1/s^2 or 1/s",
             .text = "blocks are written where a cell exceeds it: 1/s^2 of q, 1/s of vorticity",
             .at_least = 0},
            threshold);
    f.visit({.name = "edge", .unit = "-", .text = "cells along an edge of a block", .at_least = 4, .at_most = 64},
            edge);
}

} // namespace skein
