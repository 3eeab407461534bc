// States in which a rod cannot go on: numbers that are not finite, an inverted element, or stretch beyond the tension
// limit.
#pragma once

#include "skein/rod/rod_group.hpp"
#include "skein/rod/slot.hpp"

#include <optional>
#include <span>
#include <string>

namespace skein {

inline constexpr double least_half_cosine = 0.0707; ///< |cos(theta/2)| of 3 rad between neighbouring elements
inline constexpr double least_dilatation = 0.05;

/// Largest valid dilatation. Directors flip beyond the tension limit, so a run must not go on.
double most_dilatation(const RodGroup& group);

/// Element at which the state of a rod is invalid, and why.
struct InvalidState {
    int element;
    bool finite;        ///< true where all numbers are finite, but the shape is out of bounds
    std::string reason; ///< "element 3: dilatation e = ..."
};
/// First invalid element along the rod.
std::optional<InvalidState> find_invalid(const RodGroup& group, std::span<const Slot<1>> state);

/// "; tension instability of element ..." for the most stretched element, where it is beyond the group's tension limit.
/// Directors flip there, which causes all other faults.
std::string tension_hint(const RodGroup& group, std::span<const Slot<1>> state);

/// Line on the largest pull that the law "incompressible" bears, E A, where the most stretched element is not far from
/// it; empty otherwise. theory.md (11)
std::string law_hint(const RodGroup& group, std::span<const Slot<1>> state);

} // namespace skein
