// Speed of the fastest node of this rank's bodies, or wall, by which implicit steps of what touches are cut.
#pragma once

#include "contact/wall.hpp"
#include "skein/rod/rod_group.hpp"
#include "tiles/rods.hpp"

#include <cstdint>
#include <span>

namespace skein {

/// Speed of the fastest node, m/s, and the body that it is of; -1: none moves.
struct FastestNode {
    double speed = 0;
    std::int64_t gid = -1;
};
/// The fastest of bodies in their present state; of rigid ones, of their surface.
FastestNode fastest_node(const Rods& rods, std::span<const RodGroup> groups);
/// Speed of the fastest wall, m/s; `walls`: null where there are none.
double fastest_wall(const Walls* walls);
/// Radius of the thinnest element or part of a body, m.
double thinnest(const RodGroup& group);

} // namespace skein
