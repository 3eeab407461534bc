// State of one element and its first node, for W rods side by side: the record that streams through the step.
#pragma once

#include "skein/core/quaternion.hpp"

namespace skein {

template <int W> struct Slot {
    Vec3<Pack<W>> position;       ///< node k, lab, m
    Vec3<Pack<W>> velocity;       ///< node k, lab, m/s
    Quaternion<Pack<W>> director; ///< element k, the frame d1 d2 d3
    Vec3<Pack<W>> spin;           ///< element k, body, rad/s
};

template <int W> Slot<1> lane(const Slot<W>& s, int i) {
    return {broadcast<1>(lane(s.position, i)), broadcast<1>(lane(s.velocity, i)), broadcast<1>(lane(s.director, i)),
            broadcast<1>(lane(s.spin, i))};
}
template <int W> void set_lane(Slot<W>& s, int i, const Slot<1>& one) {
    set_lane(s.position, i, lane(one.position, 0));
    set_lane(s.velocity, i, lane(one.velocity, 0));
    set_lane(s.director, i, lane(one.director, 0));
    set_lane(s.spin, i, lane(one.spin, 0));
}

/// Prefetches a slot.
template <int W> SKEIN_INLINE void prefetch(const Slot<W>& slot) {
    for (std::size_t line = 0; line < sizeof(Slot<W>); line += 64)
        __builtin_prefetch(reinterpret_cast<const char*>(&slot) + line, 1, 2);
}

/// Rows d1, d2, d3.
inline Mat3d frame(const Slot<1>& slot) { return matrix(lane(slot.director, 0)); }

/// Doubles of one rod's slot. The last slot of a rod has a node but no element: its director is not turned, its spin is
/// 0.
inline constexpr int slot_doubles = 13;
static_assert(sizeof(Slot<1>) == slot_doubles * sizeof(double));

} // namespace skein
