#include "io/output_spec.hpp"

#include <algorithm>

namespace skein {

void OutputSpec::fields(FieldVisitor& f) {
    frame_fields(f);
    f.visit({.name = "series",
             .unit = "s",
             .text = "interval of the time series of observables, beside a row at the end; 0: none, but for the end of "
                     "a relaxation",
             .at_least = 0},
            series);
    f.visit({.name = "fields",
             .unit = "s",
             .text = "interval of files of the fluid (HDF5, XDMF): velocity, vorticity, Q and pressure at the middles "
                     "of cells, "
                     "beside one at the end; 0: none",
             .at_least = 0},
            fluid_fields);
    f.visit({.name = "contacts",
             .unit = "s",
             .text = "interval of tables of all contacts between rods (CSV): who, where, force, overlap, friction "
                     "spring, slip; "
                     "beside one at the end; 0: none",
             .at_least = 0},
            contacts);
    f.visit({.name = "observables",
             .unit = "",
             .text = "added to the series: any of \"angular_momentum\", \"curvature\", \"knots\", \"order\""},
            observables);
    f.visit({.name = "audit",
             .unit = "",
             .text = "adds an energy audit to the series: work of loads, of moving walls and of a fluid, dissipation, "
                     "and the defect of the balance"},
            audit);
    checkpoint_fields(f);
    f.visit({.name = "progress",
             .unit = "",
             .text = "columns of the series that the progress line shows, without units, e.g. "
                     "[\"kinetic_translation\", \"max_speed\"]"},
            progress);
}

void OutputSpec::frame_fields(FieldVisitor& f) {
    f.visit(
        {.name = "trajectory",
         .unit = "s",
         .text = "interval of whole-rod frames (HDF5), beside one at the end; 0: none, but for the end of a relaxation",
         .at_least = 0},
        trajectory);
    f.visit({.name = "directors", .unit = "", .text = "trajectory frames hold directors"}, directors);
    f.choice({.name = "precision", .unit = "", .text = "of trajectory and tip frames"}, precision, precision_names);
    f.choice({.name = "paraview",
              .unit = "",
              .text = "frames of the trajectory for ParaView; vtp: as poly data (rods.pvd, walls.pvd) and XDMF; xdmf: "
                      "a side-car of the "
                      "HDF5 files alone; none: neither; auto: vtp up to 100000 nodes, xdmf beyond"},
             paraview, paraview_names);
    f.visit({.name = "tips",
             .unit = "s",
             .text = "interval of frames of every rod's last node, beside one at the end; 0: none",
             .at_least = 0},
            tips);
    f.visit({.name = "both_ends", .unit = "", .text = "frames of tips hold every rod's first node too"}, both_ends);
}

void OutputSpec::checkpoint_fields(FieldVisitor& f) {
    f.visit(
        {.name = "checkpoint",
         .unit = "s",
         .text = "interval of checkpoints in simulated time, beside those by wall time and the one at the end; 0: none",
         .at_least = 0},
        checkpoint);
    f.visit({.name = "checkpoint_wall",
             .unit = "s",
             .text = "interval of checkpoints in wall time, which is what a failure may cost; when they come changes "
                     "no number; 0: "
                     "none",
             .at_least = 0},
            checkpoint_wall);
    f.visit({.name = "frames_wall",
             .unit = "s",
             .text = "interval of wall time in which frames and the series are put into files that others can read "
                     "while the run "
                     "goes on; 0: at checkpoints alone",
             .at_least = 0},
            frames_wall);
    f.visit({.name = "keep", .unit = "-", .text = "how many of the newest checkpoints stay", .at_least = 1}, keep);
    f.visit({.name = "milestones", .unit = "", .text = "older checkpoints stay at doubling ages, a dozen in a month"},
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
