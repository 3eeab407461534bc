// Three formulas of time alone, with their rates: a prescribed quantity of a whole group, computed once a step.
#pragma once

#include "formula/formula.hpp"
#include "skein/core/vec3.hpp"

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

class VectorOfTime {
public:
    /// Reads formulas in the unit expected. Nothing is read where the names of the scope have faults; these are
    /// reported elsewhere.
    VectorOfTime(const FormulaScope& scope, const std::vector<std::string>& texts, std::string_view unit);

    struct Point {
        Vec3d value{0, 0, 0}, rate{0, 0, 0}; ///< the rate is the derivative of the formula, 1/s
    };
    /// Value and rate; 0 where there are faults.
    Point operator()(double time) const;

    /// True where component i is 0 at all times.
    bool vanishes(std::size_t i) const;

    /// Faults of formula part.formula, or of all formulas where that is -1. Values and rates are tried at the begin of
    /// the time in which they act, at its end and at some times between.
    const std::vector<FormulaFault>& faults() const { return faults_; }

private:
    void try_times(const TimeSpan& span);

    Graph graph_;
    std::vector<int> value_, rate_; ///< nodes, [3] or none
    std::vector<FormulaFault> faults_;
};

} // namespace skein
