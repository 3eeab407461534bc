// How a rod is strained, node by node: for those who look at it.                                             theory.md (5)-(10)
//   energy  of the elements beside a node, half of each, and of the cell around it, over the rest length of both halves: summed
//           over nodes times that length it is the rod's elastic energy
#pragma once

#include "rod/rod_group.hpp"

#include <span>

namespace skein {

struct NodeProfile {
    double strain = 0;    ///< axial, e - e0; mean of the elements that meet here
    double curvature = 0; ///< of the axis, 1/m; 0 at ends, unless they are clamped
    double energy = 0;    ///< elastic, J per metre of rest length
};

/// Of one rod; `out` has a place per slot. A rigid body is not strained. `state` synchronised, of time t, s.
void rod_profile(const RodGroup& group, std::span<const Slot<1>> state, double time, std::span<NodeProfile> out);

} // namespace skein
