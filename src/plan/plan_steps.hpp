// The step of a plan, and the steps at which outputs come.
#pragma once

#include "plan/plan.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace skein {

/// Sets dt, its limit and the number of steps, when groups have their limits. Throws InputError where a given step is
/// too long.
void choose_step(Plan& plan, const CoreTables& scene);
/// Finds the group with the shortest limit, which governs, and the limit of explicit steps. Throws InputError where
/// that is no number.
void find_governing(Plan& plan, const CoreTables& scene);
/// Steps of an interval, s, that end with events; at least as many as between two of these, and 0 of no interval.
std::int64_t whole_steps(double interval, const Plan& plan);
Cadence cadence_of(const OutputSpec& out, const Plan& plan);
/// Notes on outputs that come at other times than asked for.
std::vector<std::string> uneven_outputs(const Plan& plan, const CoreTables& scene);

/// Interval that an automatic step divides, so that outputs fall on whole steps.
struct Interval {
    double length = 0; ///< s
    std::string of;    ///< what it belongs to, in words
    std::string text() const;
};
/// The interval that the scene names, or else what divides all intervals of outputs; where that is not much longer than
/// the step may be, the shortest of them. Outputs that are more frequent than `least` do not count.
Interval interval_to_divide(const Plan& plan, const CoreTables& scene, double longest_step, double least = 0);

} // namespace skein
