// Relaxation in the plan of a run.
#pragma once

namespace skein {

struct RelaxationPlan {
    double tolerance = 0; ///< correction at which rods have settled
};

} // namespace skein
