// How far a curvature turns an element against the one before it. Two frames tell their rotation vector up to pi,
// theory.md (6): a cell that is to turn by more never reaches its shape.
#pragma once

#include "skein/rod/rod_spec.hpp"

#include <numbers>
#include <string>
#include <string_view>

namespace skein {

/// Of a Voronoi cell, between element `cell` and the next.
struct CellTurn {
    double angle = 0; ///< rad
    long cell = 0;
    double length = 0; ///< D, m

    static constexpr double largest = std::numbers::pi; ///< rad
    /// The curvature that turns this cell by `angle`, 1/m.
    double curvature(double angle) const { return angle / length; }
};

/// The cell that turns most at rest, or at the start. None (angle 0) of lists that have not the number of entries that
/// they need.
CellTurn rest_turn(const Shape& shape);
CellTurn start_turn(const Shape& shape);
/// The larger of both.
struct LargestTurn {
    CellTurn turn;
    std::string_view curvature; ///< "rest" or "start"
};
LargestTurn largest_turn(const Shape& shape);

class RodGroup;
/// Of the rods of a file that are held: throws InputError naming the first whose curvature at rest or at the start
/// turns a cell by pi or more. What a scene says by itself its own check refuses.
void refuse_large_turns(const RodGroup& group);

/// "turns element 4 against element 3 by 3.3 rad".
std::string text_of(const CellTurn& turn);

} // namespace skein
