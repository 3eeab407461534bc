// What joints do to the time step, and what they hold now.
#pragma once

#include "joints/joint_list.hpp"

#include <span>
#include <vector>

namespace skein {

/// Bounds of the squares of frequencies that joints add to a group's, and of the rates at which they slow it down.   theory.md (73)
struct JointBounds {
    double stiffness = 0; ///< 1/s^2
    double drag = 0;      ///< 1/s
    int element = 0;      ///< that has the largest stiffness
};
/// By group. `joints`: of all assemblies of the scene.
std::vector<JointBounds> joint_bounds(std::span<const JointSpec> tables, std::span<const std::vector<Joint>> joints,
                                      std::span<const RodGroup> groups);

/// Energy of a joint's springs, and how far its points are apart, as its elements' slots are: node and next of the first, then of
/// the second (of a body twice the same).
struct JointState {
    double energy = 0, gap = 0;
};
JointState joint_state(const JointSpec& table, const Joint& joint, const Slot<1>& a, const Slot<1>& a_next, const Slot<1>& b,
                       const Slot<1>& b_next);

} // namespace skein
