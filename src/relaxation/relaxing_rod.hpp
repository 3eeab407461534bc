// Constants of a rod that relaxes, node by node: free directions, farthest step, and a small stiffness. The latter
// gives free rods a finite solution. theory.md (65), (67)
#pragma once

#include "relaxation/relaxation_estimate.hpp"
#include "rod/slot_freedom.hpp"
#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace skein {

class RelaxingRod {
public:
    static constexpr double farthest_turn = 0.1; ///< rad in a step
    /// share of the radius across an element, whose stretch is then of order (r/l)^2
    static constexpr double farthest_share = 2;
    static constexpr double own_share = 0.1; ///< share of EI/L^3 and of EI/L, spread over the rod

    struct Row {
        std::array<double, 6> free; ///< 0: held; node and element, along lab axes
        double own_node, own_turn;  ///< N/m, N m
        double most_turn;           ///< rad in a step
    };

    /// `held`: with the stiffness of joints, which adds to the small one.
    RelaxingRod(const RodGroup& group, const RelaxationContacts& held) {
        const int n = group.elements();
        for (const ElementConstants& e : group.element) length_ += e.rest_length;
        double bending = 0;
        for (const ElementConstants& e : group.element)
            bending += 0.5 * (e.bending.x + e.bending.y) * e.rest_length / length_;
        const double per_length = own_share * bending / (length_ * length_);
        const std::vector<SlotFreedom> freedom = slot_freedoms(group);
        for (int k = 0; k <= n; ++k) {
            Row& row = row_.emplace_back();
            row.free = nth(freedom, k).free;
            row.own_node = per_length * nth(group.node_length, k) / (length_ * length_);
            if (k < n) {
                const ElementConstants& e = nth(group.element, k);
                row.own_turn = per_length * e.rest_length;
                row.most_turn = std::min(farthest_turn, farthest_share * e.radius * e.inv_rest_length);
            }
            if (held.node.empty()) continue;
            row.own_node += nth(held.node, k);
            if (k < n) row.own_turn += nth(held.turn, k);
        }
    }

    double length() const { return length_; } ///< m
    /// Constants of node k and its element; the last node of an open rod has none.
    const Row& operator[](int k) const { return nth(row_, k); }

private:
    double length_ = 0;
    std::vector<Row> row_; ///< [n + 1]
};

} // namespace skein
