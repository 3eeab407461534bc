// The shape that a rod starts with.
#pragma once

#include "skein/core/quaternion.hpp"

#include <vector>

namespace skein {

class RodGroup;

/// Nodes and frames at t = 0 before a rod is turned: lab components, positions relative to the origin of the rod.
struct StartShape {
    std::vector<Vec3d> offsets;         ///< [slots], positions of the nodes, m
    std::vector<Quaterniond> directors; ///< [n], frames of the elements
    Quaterniond end_frame;              ///< frame of the wall at s = length
    Vec3d centre;                       ///< mean position of the nodes, m

    /// Joins the elements of a rod from s = 0: each cell, and the half cells at both ends, turns the frame by its start
    /// curvature. The constants of `group` and its frame must be known. Throws InputError where a ring does not close.
    void lay_out(const RodGroup& group);
};

} // namespace skein
