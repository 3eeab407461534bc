// Cost and error of the same scene by explicit and by implicit steps, and the line of the plan that compares them.
#pragma once

#include "plan/plan_line.hpp"
#include "skein/time/integrator.hpp"

namespace skein {

struct MethodCosts {
    struct Cost {
        Integrator integrator;
        double seconds; ///< wall time of the steps; infinite: more than the other's
        double error;   ///< of positions by the steps, over the largest length; 0: not known
    };
    Cost of_explicit, of_implicit;
    double trial_s = 0; ///< core time of the trials
    double covered = 0; ///< share of the duration that the trial of implicit steps came to

    enum class Pays { explicit_steps, implicit_steps, neither };
    /// Implicit steps where they take less than half the time, explicit ones where they take no more: their error is
    /// the smaller.
    Pays pays() const;
};

PlanLine line_of(const MethodCosts& costs);

} // namespace skein
