// Limits that joints set to the time step, and energies that they hold.
#pragma once

#include "joints/joint_events.hpp"
#include "joints/junction.hpp"

#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace skein {

/// Bounds of the squares of frequencies that joints add to a group's, and of the rates at which they slow it down.
/// theory.md (73)
struct JointBounds {
    double stiffness = 0;  ///< 1/s^2
    double drag = 0;       ///< 1/s
    int element = 0;       ///< element with the largest stiffness
    double eigenvalue = 0; ///< eigenvalue of an element that half cells hold beside a junction, with its own cells,
                           ///< 1/s^2; of a body theirs alone
    int element_of_eigenvalue = 0; ///< element with that eigenvalue
};
/// By group. `joints`: of all assemblies of the scene.
std::vector<JointBounds> joint_bounds(std::span<const JointSpec> tables, std::span<const std::vector<Joint>> joints,
                                      std::span<const RodGroup> groups);

/// Way, m, along a slider between two bodies up to which the limits hold: its forces act on the second with that lever.
double slider_way(const JointSpec& table, const Joint& joint);

/// Stiffness of joints that a node, N/m, and an element, N m/rad, of a rod feel at most, where all that are joined may
/// move at once: four times k at a point that two nodes, an arm and their counterparts move, and twice k_t or the
/// largest of half cells that meet.
struct JointHolds {
    std::vector<double> node, turn; ///< [elements + 1], [elements]; empty: no rod of the group is joined
};
/// Largest stiffness of joints over the rods of each group.
std::vector<JointHolds> joint_holds(std::span<const JointSpec> tables, std::span<const std::vector<Joint>> joints,
                                    std::span<const RodGroup> groups);

/// Energy of a joint's springs, J, distance of its points, m, and force between them, N; works along its free axes
/// since the start, J.
struct JointState {
    double energy = 0, gap = 0, force = 0, motor_work = 0, lost_work = 0;
};
/// Energy of a junction's half cells, J. element_of(group, rod, k): a slot and the next.
double star_energy(const Star& star,
                   const std::function<std::pair<Slot<1>, Slot<1>>(int, std::int64_t, int)>& element_of);
/// True of a joint with this memory that has come to an end.
bool has_ended(std::span<const double> memory);
/// Slots are node and next of the first element, then of the second, at `time`; a body has one slot twice. `memory`: of
/// the joint; none: as before its first step. `rod`: number of the first side's rod in its group.
JointState joint_state(const JointSpec& table, const Joint& joint, const Slot<1>& a, const Slot<1>& a_next,
                       const Slot<1>& b, const Slot<1>& b_next, double time, std::int64_t rod,
                       std::span<const double> memory);

} // namespace skein
