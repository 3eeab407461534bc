// Stiffness between slots of bodies at rest.
//   unknowns of a slot   displacement of its node, lab, and turn of its element, body
#pragma once

#include <array>
#include <cstddef>

namespace skein {

/// Unknowns of a slot.
inline constexpr int slot_unknowns = 6;
using StiffnessBlock = std::array<std::array<double, slot_unknowns>, slot_unknowns>;

/// Stiffness between slots of any rods.
struct SlotCoupling {
    std::size_t row, column;
    StiffnessBlock block;
};

} // namespace skein
