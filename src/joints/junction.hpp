// Common nodes of joints of kind fixed with stiffness = "auto" (hubs), and half cells that meet in one turning frame
// (stars). theory.md (73a)-(73e)
#pragma once

#include "joints/joint_list.hpp"

#include <span>
#include <vector>

namespace skein {

inline Mat3d inverse(const Mat3d& m) {
    const Vec3d a = cross(m.d2, m.d3), b = cross(m.d3, m.d1), c = cross(m.d1, m.d2);
    const double scale = 1 / dot(m.d1, a);
    return {scale * Vec3d{a.x, b.x, c.x}, scale * Vec3d{a.y, b.y, c.y}, scale * Vec3d{a.z, b.z, c.z}};
}

/// Such a joint has one common node. It turns by half cells too, unless the scene gives it a torsional spring.
inline bool shares_node(const JointSpec& spec) { return spec.kind == JointKind::fixed && spec.law.stiffness == 0; }
inline bool turns_by_half_cells(const JointSpec& spec) {
    return shares_node(spec) && spec.law.torsional_stiffness == 0;
}
/// Such a joint comes apart where rods are strained too much.
inline bool tears(const JointSpec& spec) { return shares_node(spec) && spec.events.break_strain > 0; }
/// True where a table has springs or dashpots besides.
inline bool has_springs(const JointSpec& spec) {
    return !shares_node(spec) || spec.law.damped() || spec.law.torsional_stiffness > 0;
}

inline constexpr std::size_t no_joint = static_cast<std::size_t>(-1);

/// Nodes that move as one. The first may be held, or a body with the others at fixed places of it.
struct Hub {
    struct Member {
        int group;
        std::int64_t rod; ///< in the copy
        int node;         ///< node of a rod; 0 of a body
        Vec3d arm;        ///< from a body's centre to this node, body axes of the body, m
    };
    std::vector<Member> members;
    bool body = false;            ///< the first is one
    bool held = false;            ///< the first does not move by loads
    std::size_t joint = no_joint; ///< whose tearing ends it
};

/// Half cells that meet in a place. Element i turns against the first by log(Q_i (C_i Q_0)^T). Moments of the half
/// cells add up to none in a frame between them without inertia. If the first is rigid, it is the frame. A star of
/// negative stiffnesses takes off the cell that a rod has there itself.
struct Star {
    struct Member {
        int group;
        std::int64_t rod;
        int element;
        double side; ///< 1: the element is after the place, -1: before it, 0: of an inner node, whose own cell has its
                     ///< muscles
        Quaterniond rest;    ///< C_i
        Mat3d turn;          ///< C_i as a matrix
        Vec3d stiffness;     ///< K_i = 2 B/l, N m/rad; 0 of a rigid first
        Vec3d compliance;    ///< l/2B
        Vec3d rest_turn;     ///< rest turn of the half cell since the start, outwards, rad
        Mat3d to_frame;      ///< A_i: what it turns the frame by
        double length;       ///< length of the element, m; 0 of a rigid first
        double share;        ///< in the dilatation of the joint
        double rest_stretch; ///< e0
    };
    std::vector<Member> members;
    bool rigid = false;           ///< the first is a body, or held
    bool along_axes = false;      ///< C_i keep d3, so that bending and twist stay apart
    Law law = Law::linear;        ///< law of all members; linear where they differ
    double inv_cell = 0;          ///< 2/sum of lengths, 1/m
    double largest = 0;           ///< bound of K between two members, N m/rad
    std::size_t joint = no_joint; ///< whose tearing ends it
    double break_strain = 0;

    /// Mean stretch of its elements over that at rest, as they are.
    double rest_dilatation() const {
        double sum = 0;
        for (const Member& m : members) sum += m.share * m.rest_stretch;
        return sum;
    }
};

struct Junctions {
    std::vector<Hub> hubs;
    std::vector<Star> stars;
    bool empty() const { return hubs.empty(); }
};

inline constexpr std::size_t most_members = 16;

/// Junctions of a copy of an assembly with these joints. Throws InputError, with the line of the table and a cure,
/// where a place is off nodes or axes, or two things hold it.
Junctions junctions_of(std::span<const JointSpec> tables, std::span<const Joint> joints,
                       std::span<const RodGroup> groups);

} // namespace skein
