// Shares of the inertia of a rod in a fluid that its steps feel; the fluid carries the rest. theory.md (88)
#pragma once

#include "skein/core/index.hpp"
#include "skein/core/vec3.hpp"

#include <vector>

namespace skein {

struct KickedShares {
    std::vector<double> of_nodes;   ///< [n + 1]; none without a fluid
    std::vector<Vec3d> of_elements; ///< [n], body

    bool any() const { return !of_nodes.empty(); }
    double of_node(int i) const { return any() ? nth(of_nodes, i) : 1.0; }
    Vec3d of_element(int k) const { return any() ? nth(of_elements, k) : Vec3d{1, 1, 1}; }
};

} // namespace skein
