// Joints of one copy of an assembly: elements that they join, and places on these.
#pragma once

#include "joints/joint_spec.hpp"
#include "skein/rod/rod_group.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

/// One side of a joint: a point that moves with an element, between its nodes and off its axis.
struct JointEnd {
    static constexpr int world = -1; ///< `group` of an end that is fixed in the axes of the copy; its arm is the place

    int group;
    std::int64_t rod; ///< in the copy
    int element;
    double share; ///< share of the second node in the point's place; 0 of a body
    Vec3d arm;    ///< from there to the point, body, m
    Vec3d axis;   ///< axis of a hinge, body; of spherical joints both are of the first: its axis, and one across

    bool of_world() const { return group == world; }
};

struct Joint {
    std::size_t table; ///< number of its [[joint]]
    JointEnd first, second;
    Quaterniond rest;     ///< C of a fixed joint: Q2 = C Q1 at the start
    double rest_distance; ///< distance of the elements' centres at the start, m
};

/// Number of the rod on a joint's first side in its group, in a copy: `rod` of the formulas of motors.
double rod_number(const Joint& joint, std::span<const RodGroup> groups, std::int64_t copy);
/// Numbers of the memory of joints that a rod of a group is the first side of at most, by group of the scene: all of
/// its rods have as many.
std::vector<std::size_t> joint_memory_of_groups(std::span<const JointSpec> tables, std::span<const Joint> joints,
                                                std::size_t groups);

/// Range of a joint's numbers among those of the rod that is its first side, as many as of its group.
struct JointNumbers {
    std::size_t before, count;
};
JointNumbers numbers_of_joint(std::span<const JointSpec> tables, std::span<const Joint> joints, std::size_t joint);

/// Joints of a scene: its tables, and the joints of a copy of each assembly.
struct JointLists {
    std::vector<JointSpec> tables;
    std::vector<std::vector<Joint>> of_assembly;
};

/// Joints of an assembly by number, in the order of the scene's tables and within one by rods and elements. `groups`:
/// of the scene. Throws InputError, with the table's line, where nothing is joined, or rods have no element there.
std::vector<Joint> joints_of(std::span<const JointSpec> tables, std::span<const RodGroup> groups, int assembly);

} // namespace skein
