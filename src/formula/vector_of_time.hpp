// Three formulas of time alone, with their rates: a prescribed quantity of a whole group, computed once a step. Or of
// time and the number of a rod, for quantities of single rods.
#pragma once

#include "formula/formula.hpp"
#include "formula/program.hpp"
#include "skein/core/vec3.hpp"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

class VectorOfTime {
public:
    /// Reads formulas in the unit expected. Nothing is read where the names of the scope have faults; these are
    /// reported elsewhere.
    /// `rods`: true where formulas may hold `rod`.
    VectorOfTime(const FormulaScope& scope, const std::vector<std::string>& texts, std::string_view unit,
                 bool rods = false);

    struct Point {
        Vec3d value{0, 0, 0}, rate{0, 0, 0}; ///< the rate is the derivative of the formula, 1/s
    };
    /// Value and rate for a rod; 0 where there are faults.
    Point operator()(double time, double rod = 0) const;
    /// Program of the three values and their three rates where they change with the rod, null elsewhere.
    const FormulaProgram* by_rod() const { return by_rod_ ? &*by_rod_ : nullptr; }

    /// Trial of a vector that changes with the rod at `times` + 1 moments from 0 to `duration`, s, for each of these
    /// rods.
    struct Tried {
        Vec3d largest{0, 0, 0};           ///< of sizes of its components that are finite
        std::optional<double> not_finite; ///< the first rod of which a value or rate is not
    };
    Tried try_rods(double duration, int times, std::span<const double> rods) const;

    /// True where component i is 0 at all times.
    bool vanishes(std::size_t i) const;

    /// Faults of formula part.formula, or of all formulas where that is -1. Values and rates are tried at the begin of
    /// the time in which they act, at its end and at some times between; those that change with the rod by try_rods().
    const std::vector<FormulaFault>& faults() const { return faults_; }

private:
    void try_times(const TimeSpan& span);

    Graph graph_;
    std::vector<int> value_, rate_; ///< nodes, [3] or none
    std::vector<FormulaFault> faults_;
    std::optional<FormulaProgram> by_rod_;
};

} // namespace skein
