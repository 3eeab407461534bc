// Quantities of a case at rest, and their slopes by a number of its scene.                            theory.md (104)
#pragma once

#include "equilibrium/static_solution.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "studies/scene_family.hpp"

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace skein {

/// Equilibrium from the bodies' places in the scene. Throws NumericalError where there is none.
StaticState equilibrium_of(StaticCase& one, double time);

/// Columns of observables.csv in a state.
struct ObservedState {
    std::vector<std::string> names; ///< with units
    std::vector<double> values;
};
ObservedState observe(const Communicator& comm, const Threads& threads, const StaticCase& one,
                      const StaticState& state);

/// A case whose number is changed.
struct ChangedCase {
    std::unique_ptr<StaticCase> at;
    double by;
};
/// Cases whose number is less and more by `by`; where one side has no scene, as of a bound, the case as it is stands
/// for it. `make`: the case with a change. Throws InputError where neither side has one.
std::pair<ChangedCase, ChangedCase> changed_cases(double by,
                                                  const std::function<std::unique_ptr<StaticCase>(double)>& make);

/// Slopes of a quantity at the equilibrium `state` by the number.
Unknown slopes_at_rest(const StaticSolution& solution, const StaticState& state, const ChangedCase& low,
                       const ChangedCase& high,
                       const std::function<Unknown(const StaticCase&, const StaticState&)>& quantity);

} // namespace skein
