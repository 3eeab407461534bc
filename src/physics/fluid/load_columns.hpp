// Columns of the time series with the load of a fluid on single rods and bodies.
#pragma once

#include "immersion/immersed_rods.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace skein {

struct SceneSpec;

/// Force or couple on a single rod or body: three columns.
struct LoadColumns {
    std::string name;       ///< without component and unit
    std::size_t single = 0; ///< number among SingleLoads::rods
    bool couple = false;
};

struct SingleLoads {
    std::vector<RodNumber> rods; ///< each once
    std::vector<LoadColumns> columns;
};

/// Loads that output.fluid_forces and probes ask for. Throws InputError where they are too many.
SingleLoads single_loads(const SceneSpec& scene, std::span<const RodGroup> groups);

/// Their line in the plan; empty without any.
std::string single_loads_text(const SingleLoads& loads);

} // namespace skein
