#include "time/time_spec.hpp"

namespace skein {

void TimeSpec::fields(FieldVisitor& f) {
    f.visit({.name = "duration", .unit = "s", .text = "time to simulate", .required = true, .above = 0}, duration);
    f.visit({.name = "dt",
             .unit = "s",
             .text = "time step; 0: automatic, `safety` times the limit",
             .at_least = 0,
             .automatic = 0},
            dt);
    f.visit({.name = "divide",
             .unit = "s",
             .text = "interval that an automatic step divides; 0: interval of the most frequent output except "
                     "checkpoints, or the duration",
             .at_least = 0},
            divide);
    f.visit({.name = "safety",
             .unit = "-",
             .text = "ratio of the automatic step to the stability limit; at most 0.6 is used for rods without damping",
             .above = 0,
             .at_most = 1},
            safety);
    f.visit({.name = "e_min",
             .unit = "-",
             .text = "smallest expected dilatation; the automatic step shrinks with it",
             .above = 0,
             .at_most = 1},
            e_min);
    f.visit({.name = "tolerance",
             .unit = "-",
             .text = "implicit integrators with an automatic step, outside of a fluid: error of positions at the end "
                     "that steps are cut into parts for, over the largest length of the scene",
             .above = 0,
             .at_most = 1},
            tolerance);
    f.choice({.name = "integrator",
              .text =
                  "verlet: second order; pefrl: fourth order, in four force evaluations; implicit_damped: second order "
                  "at any step, damps what steps do not resolve; implicit: the same, keeps energy and momenta; "
                  "implicit_bed: first order, slow rods in contact"},
             integrator, integrator_names);
    f.choice({.name = "damping",
              .text = "combination of damping and kick (docs/theory.md 7): midpoint; exponential, which pefrl always "
                      "uses; after: as in published codes, first order"},
             damping, damping_scheme_names);
    f.visit({.name = "rest_speed",
             .unit = "m/s",
             .text = "the run ends at the first row of the series after the start in which no node is faster; 0: never",
             .at_least = 0},
            rest_speed);
    f.visit({.name = "relax",
             .text = "find the state of rest instead of the motion (docs/theory.md 21): inertia and damping are chosen "
                     "automatically, time counts steps of 1 s, `duration` is the largest number of steps, and the run "
                     "ends when all rods have settled"},
            relax);
    f.visit({.name = "relax_tolerance",
             .unit = "-",
             .text = "rods have settled when no correction exceeds this share of a rod's length, or this angle [rad]",
             .above = 0},
            relax_tolerance);
    f.visit({.name = "force_dt", .text = "accept a `dt` beyond the stability limit"}, force_dt);
}

} // namespace skein
