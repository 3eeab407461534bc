// Names that the formulas of a scene may hold: constants, tables, and the variables of the place that a formula is for.
#pragma once

#include "formula/unit.hpp"
#include "skein/core/fields.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// An entry of [constants].
struct FormulaConstant {
    std::string name;
    double value = 0;
    std::string unit; ///< unit; empty fits any
};

/// A [[table]], piecewise linear from point to point. Beyond its ends it keeps the values there, or repeats.
struct FormulaTable {
    std::string name;
    std::vector<double> at, value;
    std::string at_unit = "s", unit; ///< units; empty fits any
    bool periodic = false;
    std::string file;   ///< file of comma-separated values, from which `at` and `value` are read; empty once they are
    std::string source; ///< file:line of the table, for messages

    /// Points set by a program that drives the run (skein/run.hpp). This table and all its copies use them in place of
    /// their own.
    std::shared_ptr<FormulaTable> driven{};

    void fields(FieldVisitor& f);

    double operator()(double x) const { return (driven ? *driven : *this).line(x).first; }
    double slope(double x) const { return (driven ? *driven : *this).line(x).second; }

private:
    std::pair<double, double> line(double x) const; ///< value and slope at x
};

/// A part of the run, s.
struct TimeSpan {
    double begin = 0, end = std::numeric_limits<double>::max();

    TimeSpan within(const TimeSpan& other) const { return {std::max(begin, other.begin), std::min(end, other.end)}; }
    bool empty() const { return begin > end; }
    /// The time at a share of the way from its begin to its end.
    double at(double share) const { return begin + (end - begin) * share; }
};

struct FormulaScope {
    std::vector<FormulaConstant> constants;
    std::vector<FormulaTable> tables;
    double duration = 0; ///< duration of the run, s
    TimeSpan acts{};     ///< in which formulas surely act, and must have values: the present stage

    TimeSpan run() const { return {0, duration}; }
    TimeSpan tried() const { return run().within(acts); }
};

/// Variables, in this order. A place is a node for forces, and the middle of an element for couples.
enum class Variable { x, y, z, vx, vy, vz, t, s, length, rod, start_x, start_y, start_z };
inline constexpr int variables = 13;
struct VariableEntry {
    std::string_view name, unit, text;
};
inline constexpr VariableEntry variable_names[variables] = {{"x", "m", "lab position"},
                                                            {"y", "m", ""},
                                                            {"z", "m", ""},
                                                            {"vx", "m/s", "lab velocity"},
                                                            {"vy", "m/s", ""},
                                                            {"vz", "m/s", ""},
                                                            {"t", "s", "time"},
                                                            {"s", "m", "arc length at rest, from the start"},
                                                            {"L", "m", "length of the rod at rest"},
                                                            {"rod", "", "number of the rod in its group, from 0"},
                                                            {"X", "m", "lab position at the start"},
                                                            {"Y", "m", ""},
                                                            {"Z", "m", ""}};

/// Dependences of a value.
inline constexpr unsigned with_time = 1, with_place = 2, with_state = 4;
inline unsigned changes_with(Variable v) {
    if (v == Variable::t) return with_time;
    return v < Variable::t ? with_state : with_place;
}

/// Faults of the constants and tables themselves: path of a key ("constants.k", "table.0.at") and message.
std::vector<std::pair<std::string, std::string>> faults(const FormulaScope& scope);

} // namespace skein
