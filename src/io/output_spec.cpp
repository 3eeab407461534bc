#include "io/output_spec.hpp"

#include <algorithm>

namespace skein {

void OutputSpec::fields(FieldVisitor& f) {
    frame_fields(f);
    f.visit({.name = "series",
             .unit = "s",
             .text = "interval of the time series of observables, with a row at the end; 0: none, except at the end of "
                     "a relaxation",
             .at_least = 0},
            series);
    f.visit({.name = "fields",
             .unit = "s",
             .text = "interval between files of the fluid (HDF5, XDMF), with one at the end: velocity, vorticity, Q "
                     "and pressure at the middles of cells; 0: none",
             .at_least = 0},
            fluid_fields);
    f.visit({.name = "contacts",
             .unit = "s",
             .text = "interval between tables of all contacts between rods (CSV), with one at the end: rods, place, "
                     "force, overlap, friction spring, slip; 0: none",
             .at_least = 0},
            contacts);
    f.visit(
        {.name = "observables",
         .unit = "",
         .text =
             "additional observables of the series: any of \"angular_momentum\", \"curvature\", \"knots\", \"order\""},
        observables);
    f.visit({.name = "fluid_forces",
             .unit = "",
             .text = "groups, e.g. [\"fish\"]: each of their rods and bodies gets six columns of the series, the mean "
                     "force and couple of the fluid on it; at most 1000 rods and bodies"},
            fluid_forces);
    f.visit({.name = "fluid_power",
             .unit = "",
             .text =
                 "true: adds to the series the power that bodies give a fluid at their surfaces, and the part of it "
                 "that is lost there"},
            fluid_power);
    f.visit({.name = "audit",
             .unit = "",
             .text = "true: adds an energy audit to the series: work of loads and moving walls, dissipation, and the "
                     "defect of the balance"},
            audit);
    checkpoint_fields(f);
    f.visit({.name = "progress",
             .unit = "",
             .text = "columns of the series in the progress line, without units, e.g. [\"kinetic_translation\", "
                     "\"max_speed\"]"},
            progress);
}

void OutputSpec::frame_fields(FieldVisitor& f) {
    f.visit({.name = "trajectory",
             .unit = "s",
             .text = "interval between frames of whole rods (HDF5), with one at the end; 0: none, except at the end of "
                     "a relaxation",
             .at_least = 0},
            trajectory);
    f.visit({.name = "directors", .unit = "", .text = "true: trajectory frames contain directors"}, directors);
    f.choice({.name = "precision", .unit = "", .text = "precision of trajectory and tip frames"}, precision,
             precision_names);
    f.choice({.name = "paraview",
              .unit = "",
              .text = "files for ParaView; vtp: poly data (rods.pvd, walls.pvd) and XDMF; xdmf: only an XDMF file for "
                      "the HDF5 files; none: no such files; auto: vtp up to 100000 nodes, otherwise xdmf"},
             paraview, paraview_names);
    f.visit({.name = "tips",
             .unit = "s",
             .text = "interval between frames of every rod's last node, with one at the end; 0: none",
             .at_least = 0},
            tips);
    f.visit({.name = "both_ends", .unit = "", .text = "true: frames of tips also contain every rod's first node"},
            both_ends);
}

void OutputSpec::checkpoint_fields(FieldVisitor& f) {
    f.visit({.name = "checkpoint",
             .unit = "s",
             .text = "interval between checkpoints in simulated time, in addition to checkpoints by wall time and at "
                     "the end; 0: none",
             .at_least = 0},
            checkpoint);
    f.visit({.name = "checkpoint_wall",
             .unit = "s",
             .text = "interval between checkpoints in wall time, the largest loss by a failure; it does not change "
                     "results; 0: none",
             .at_least = 0},
            checkpoint_wall);
    f.visit({.name = "frames_wall",
             .unit = "s",
             .text = "interval of wall time at which frames and the series are written to files that can be read "
                     "during the run; 0: at checkpoints only",
             .at_least = 0},
            frames_wall);
    f.visit({.name = "keep", .unit = "-", .text = "number of newest checkpoints to keep", .at_least = 1}, keep);
    f.visit({.name = "milestones",
             .unit = "",
             .text = "true: also keeps older checkpoints at doubling ages, about a dozen in a month"},
            milestones);
}

bool OutputSpec::writes_vtp(std::int64_t nodes) const {
    if (trajectory == 0) return false;
    return paraview == ParaView::vtp || (paraview == ParaView::automatic && nodes <= most_nodes_of_vtp);
}

bool OutputSpec::observes(std::string_view set) const {
    return std::find(observables.begin(), observables.end(), set) != observables.end();
}

} // namespace skein
