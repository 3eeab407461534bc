// Contact of a rod with itself, as published: the spring and damper of two rods, without their pressing force.
//   i = 0 .. n-1,  j = i - skip .. 0 downwards,  skip = floor(1 + ceil(0.8 pi r_i/l_i)): neighbours would overlap in a
//   bend
#pragma once

#include "segments.hpp"

namespace skein::replay {

struct RodSelfContact {
    double stiffness, damping; ///< k, N/m; nu, N s/m
    explicit RodSelfContact(const Entry& entry);
    void add(Rod& rod) const;
};

} // namespace skein::replay
