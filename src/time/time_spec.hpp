// Keys of [time].
#pragma once

#include "skein/core/fields.hpp"
#include "skein/time/integrator.hpp"

namespace skein {

struct TimeSpec {
    double duration = 0; ///< s
    double dt = 0;       ///< s; 0: automatic (safety * limit, lowered so that it divides `divide`)
    double divide = 0; ///< s; an interval that the automatic step divides; 0: the most frequent output, or the duration
    double safety = 0.9;     ///< ratio of the automatic step to the limit
    double tolerance = 1e-3; ///< of implicit steps: error of positions in the run, over the largest length
    double e_min = 0.95;     ///< smallest dilatation expected; the automatic step shrinks with it
    double rest_speed = 0;   ///< m/s; 0: the run goes on to its end
    bool force_dt = false;   ///< true accepts a dt beyond the limit
    bool relax = false; ///< true seeks the state of rest and not the motion: steps of 1 s, at most `duration` of them
    double relax_tolerance = 1e-9; ///< correction, over the length and in rad, below which a rod counts as settled
    Integrator integrator = Integrator::verlet;
    DampingScheme damping = DampingScheme::midpoint;

    void fields(FieldVisitor& f);
};

} // namespace skein
