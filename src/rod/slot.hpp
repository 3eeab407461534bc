// The state of one element and its first node, for W rods side by side: the record that is streamed through the step.
#pragma once

#include "core/vec3.hpp"

namespace skein {

template <int W> struct Slot {
    Vec3<Pack<W>> position; ///< node k, lab, m
    Vec3<Pack<W>> velocity; ///< node k, lab, m/s
    Mat3<Pack<W>> director; ///< element k, rows d1 d2 d3
    Vec3<Pack<W>> spin;     ///< element k, body, rad/s
};

/// Doubles of one rod's slot; the last slot of a rod has a node but no element (director and spin are zero there).
inline constexpr int slot_doubles = 18;
static_assert(sizeof(Slot<1>) == slot_doubles * sizeof(double));

} // namespace skein
