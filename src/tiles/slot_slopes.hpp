// Stiffness from the slopes of loads: K = -d(loads)/d(unknowns) + [c]/2 on the turn of a slot with the couple c.
//                                                                                                       theory.md (97)
#pragma once

#include "skein/core/dual_pack.hpp"
// The above comes before all templates over packs.
#include "skein/core/vec3.hpp"
#include "tiles/slot_coupling.hpp"

namespace skein {

/// Adds a load's slopes to the block of six unknowns, whose first slope is `first`. `own`: it is the load of their
/// slot.
inline void add_slopes(const Vec3<Pack<dual>>& force, const Vec3<Pack<dual>>& couple, bool own, StiffnessBlock& block,
                       int first = 0, int count = slot_unknowns) {
    const Pack<dual>* rows[slot_unknowns] = {&force.x, &force.y, &force.z, &couple.x, &couple.y, &couple.z};
    for (std::size_t i = 0; i < slot_unknowns; ++i)
        for (int j = 0; j < count; ++j) block[i][static_cast<std::size_t>(j)] -= rows[i]->d[first + j];
    if (!own) return;
    const double x = 0.5 * couple.x.v, y = 0.5 * couple.y.v, z = 0.5 * couple.z.v;
    block[3][4] -= z;
    block[3][5] += y;
    block[4][3] += z;
    block[4][5] -= x;
    block[5][3] -= y;
    block[5][4] += x;
}

} // namespace skein
