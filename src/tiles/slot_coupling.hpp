// Stiffness between slots of bodies at rest.
//   unknowns of a slot   displacement of its node, lab, and turn of its element, body
#pragma once

#include "skein/core/vec3.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace skein {

/// Unknowns of a slot.
inline constexpr int slot_unknowns = 6;
using StiffnessBlock = std::array<std::array<double, slot_unknowns>, slot_unknowns>;

/// Adds what a force at the arm `a` of a body adds to its turn, as its moment turns with it: (a.f) 1 - (a f^T + f
/// a^T)/2, which is -[a][f] less its part of [c]/2. Both body.                                              theory.md
/// (97)
inline void add_turn_of_arm(const Vec3d& a, const Vec3d& f, StiffnessBlock& block) {
    const double af = dot(a, f), x[3] = {a.x, a.y, a.z}, y[3] = {f.x, f.y, f.z};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            block[3 + i][3 + j] += (i == j ? af : 0) - 0.5 * (x[i] * y[j] + y[i] * x[j]);
}

/// Stiffness between slots of any rods.
struct SlotCoupling {
    std::size_t row, column;
    StiffnessBlock block;
};

/// Slots of whole rods whose loads are asked for, and by whose unknowns the stiffness is: columns of it.
struct SlotShare {
    std::size_t first = 0, end = SIZE_MAX;

    bool has(std::size_t slot) const { return slot >= first && slot < end; }
};

} // namespace skein
