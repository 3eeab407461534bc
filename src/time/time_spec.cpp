#include "time/time_spec.hpp"

namespace skein {

void TimeSpec::fields(FieldVisitor& f) {
    f.visit({.name = "duration", .unit = "s", .text = "time to simulate", .required = true, .above = 0}, duration);
    f.visit({.name = "dt", .unit = "s", .text = "time step; 0: automatic, `safety` times the limit", .at_least = 0},
            dt);
    f.visit({.name = "divide",
             .unit = "s",
             .text = "interval that an automatic step divides; 0: that of the most frequent output but checkpoints, or "
                     "the duration",
             .at_least = 0},
            divide);
    f.visit({.name = "safety",
             .unit = "-",
             .text = "automatic step over the limit; rods without damping get 0.6 at most",
             .above = 0,
             .at_most = 1},
            safety);
    f.visit({.name = "e_min",
             .unit = "-",
             .text = "smallest dilatation expected; the automatic step shrinks with it",
             .above = 0,
             .at_most = 1},
            e_min);
    f.choice({.name = "integrator",
              .unit = "",
              .text = "verlet: second order; pefrl: fourth, at four times the work of a step 1.5 times as long"},
             integrator, integrator_names);
    f.choice({.name = "damping",
              .unit = "",
              .text = "how damping joins the kick (docs/theory.md 7): midpoint; exponential, which pefrl always takes; "
                      "after: as "
                      "published, first order"},
             damping, damping_scheme_names);
    f.visit(
        {.name = "rest_speed",
         .unit = "m/s",
         .text =
             "the run ends at the first row of the series, but that of the start, in which no node is faster; 0: never",
         .at_least = 0},
        rest_speed);
    f.visit({.name = "relax",
             .unit = "",
             .text = "find rest instead of motion (docs/theory.md 21): inertia and damping are chosen, time counts "
                     "steps of 1 s, of "
                     "which `duration` allows so many, and the run ends when all rods have settled"},
            relax);
    f.visit({.name = "relax_tolerance",
             .unit = "-",
             .text = "rods have settled when none wants a correction beyond this share of its length, or a turn beyond "
                     "this angle "
                     "[rad]",
             .above = 0},
            relax_tolerance);
    f.visit({.name = "force_dt", .unit = "", .text = "accept a dt beyond the limit"}, force_dt);
}

} // namespace skein
