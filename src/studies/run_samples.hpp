// Quantities that runs of one scene are compared by: the columns of the time series and ends of rods, as their files
// have them.
#pragma once

#include "skein/rod/rod_group.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// [samples][components]; x, y and z of one thing are one quantity.
struct Quantity {
    std::string name, unit;
    std::size_t components = 1;
    std::vector<double> values;
    bool of_solution = false; ///< a frequency or a critical value, which no time series has
};

struct RunSamples {
    std::vector<double> times; ///< s
    std::vector<Quantity> quantities;
};

/// From observables.csv and the frames of tips, those of the first and the last rod of every group. Where `at_end`, the
/// first and the last sample alone. Leaves out what tells of the search for contacts, of round-off and of single cells.
/// Throws IoError. For one rank alone.
RunSamples read_samples(const std::string& directory, std::span<const RodGroup> groups, bool at_end);

/// Core-seconds that a run has taken, scaled to all of its steps; `predicted` where its summary does not tell. For one
/// rank alone.
double core_seconds_of(const std::string& directory, double predicted);

} // namespace skein
