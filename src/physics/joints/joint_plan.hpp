// Assemblies and joints in the plan of a run.
#pragma once

#include "joints/joint_list.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace skein {

/// Rods that are joined, or copied together.
struct AssemblyPlan {
    std::string name;
    std::int64_t copies = 1, rods = 0, elements = 0; ///< the last two of a copy
    std::vector<std::size_t> joints_of_table;        ///< how many of each [[joint]]
};

struct JointPlan {
    std::vector<AssemblyPlan> assemblies;
    std::shared_ptr<const JointLists> joints;

    /// True where something acts along a free axis, or a joint comes to an end.
    bool has_axes() const {
        return std::any_of(joints->tables.begin(), joints->tables.end(),
                           [](const JointSpec& table) { return table.has_axes() || table.events.any(); });
    }
};

} // namespace skein
