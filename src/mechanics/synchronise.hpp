// Synchronised copy of rods: positions and directors advanced at constant rates. theory.md (21)
#pragma once

#include "mechanics/bearing.hpp"
#include "mechanics/gyration.hpp"

namespace skein {

/// Advances nodes alone, as most of the time goes into directors. `rod`: a tile across.
template <int W> void synchronise_positions(const RodTile<W>& rod, double h) {
    for (int k = 0; k <= rod.last; ++k)
        rod.slot[k].position = fma(Pack<W>(h), rod.slot[k].velocity, rod.slot[k].position);
    close_ring(rod);
}

template <int W> void synchronise(const RodTile<W>& rod, double h) {
    drift_on(bearings_of(*rod.group), rod, h,
             [&] { with_gyration(gyration_of(*rod.group), [&]<class Top>(Top) { drift<Top>(rod, h); }); });
    close_ring(rod);
}

} // namespace skein
