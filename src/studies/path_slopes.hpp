// Slopes along a path by other numbers of its scene.                                            theory.md (111)-(112)
//   point    slopes of observables, at a fixed value l of the path's number
//   limit    dl/dp = -(w . d loads/dp) / (w . d loads/dl), w K = 0
//   branch   dl/dp = -(dm/dp) / (dm/dl), m the critical eigenvalue of equilibria on the path
#pragma once

#include "studies/gradient_study.hpp"

#include <optional>
#include <string>
#include <vector>

namespace skein {

/// Eigenvalue nearest to 0 of K x = m W x, with the weights W of lengths along a path.
struct CriticalMode {
    double value = 0;
    Unknown shape; ///< x . W x = 1
};
/// `left`: of the transpose of K. `start`: a shape near it, or empty.
CriticalMode critical_mode(StaticSystem& system, const StaticState& state, bool left, Unknown start = {});

class PathSlopes {
public:
    /// `along`: the path's number; `range`: over which the path goes. All have to outlive it.
    PathSlopes(const Communicator& comm, const Threads& threads, const Machine& machine, SceneFamily& family,
               std::string along, double range, GradientOptions asked)
        : comm_(comm), threads_(threads), machine_(machine), family_(family), along_(std::move(along)), range_(range),
          asked_(std::move(asked)) {}

    /// Slopes at a point of the path; NaN where the stiffness is singular to working precision, or contacts slip.
    StateSlopes at(double value, const StaticState& state, const FrictionMemory& friction);
    /// Slopes of the path's number at the limit point of these, by the numbers. `by_value`: slope of the loads by the
    /// path's number.
    std::vector<double> of_limit(double value, const StaticState& state, const StateSlopes& there,
                                 const Unknown& by_value);
    /// The same at a branch point; NaN for numbers that a branch point does not survive.
    std::vector<double> of_branch(double value, const StaticState& state, const StateSlopes& there);

private:
    /// Critical eigenvalue of the equilibrium of another case near a state; NaN where none is found.
    double eigenvalue_near(StaticCase& at, const StaticState& state, const CriticalMode& mode) const;

    const Communicator& comm_;
    const Threads& threads_;
    const Machine& machine_;
    SceneFamily& family_;
    std::string along_;
    double range_;
    GradientOptions asked_;
};

} // namespace skein
