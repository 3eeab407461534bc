// Rotation of an element against the one before it under a curvature. The rotation vector of two frames is unique up to
// pi, theory.md (6): a cell that is to turn by more never reaches its shape.
#pragma once

#include "skein/rod/rod_spec.hpp"

#include <numbers>
#include <string>
#include <string_view>

namespace skein {

class Threads;

/// Turn of a Voronoi cell, between element `cell` and the next.
struct CellTurn {
    double angle = 0; ///< rad
    long cell = 0;
    double length = 0; ///< D, m

    static constexpr double largest = std::numbers::pi; ///< rad
    /// Curvature that turns this cell by `angle`, 1/m.
    double curvature(double angle) const { return angle / length; }
};

/// Cell with the largest turn at rest, or at the start. The angle is 0 where a list has the wrong number of entries.
CellTurn rest_turn(const Shape& shape);
CellTurn start_turn(const Shape& shape);
/// Larger of both turns.
struct LargestTurn {
    CellTurn turn;
    std::string_view curvature; ///< "rest" or "start"
};
LargestTurn largest_turn(const Shape& shape);

class RodGroup;
/// Throws InputError for the first of the held rods of a file whose curvature at rest or at the start turns a cell by
/// pi or more. Curvatures given by the scene have a check of their own.
void refuse_large_turns(const RodGroup& group, const Threads* threads = nullptr);

/// "turns element 4 against element 3 by 3.3 rad".
std::string text_of(const CellTurn& turn);

} // namespace skein
