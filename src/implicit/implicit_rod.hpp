// Constants of the rods of a group that step implicitly, node by node: free directions, inertia and damping.
#pragma once

#include "mechanics/kick.hpp"
#include "mechanics/kicked_shares.hpp"
#include "rod/body_shape.hpp"
#include "rod/slot_freedom.hpp"
#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"

#include <vector>

namespace skein {

class ImplicitRod {
public:
    struct Row : SlotFreedom {
        double mass = 0, node_rate = 0;                ///< kg, 1/s; of inertia the share that a fluid leaves
        Vec3d inertia{0, 0, 0};                        ///< kg m^2, likewise
        Vec3d rate{0, 0, 0}, rate_by_stretch{0, 0, 0}; ///< damping of the spin, 1/s: by itself and per dilatation
    };

    ImplicitRod(const RodGroup& group, const DampingRates& rates, const KickedShares& shares) {
        const int n = group.elements(), slots = group.slots();
        length_ = group.strained() ? 0 : group.body()->reach;
        if (group.strained())
            for (const ElementConstants& e : group.element) length_ += e.rest_length;
        const std::vector<SlotFreedom> freedom = slot_freedoms(group);
        for (int k = 0; k < slots; ++k) {
            Row& row = row_.emplace_back(Row{nth(freedom, k)});
            row.mass = shares.of_node(k) * nth(group.node_mass, k);
            if (!rates.none()) row.node_rate = nth(rates.node, k);
            if (k >= n) continue;
            row.inertia = scale(shares.of_element(k), nth(group.element, k).inertia);
            if (!rates.none()) row.rate = nth(rates.element, k);
            if (rates.follow_stretch()) row.rate_by_stretch = nth(rates.element_stretched, k);
        }
    }

    double length() const { return length_; } ///< m; of a body its reach
    const Row& operator[](int k) const { return nth(row_, k); }

private:
    double length_ = 0;
    std::vector<Row> row_; ///< [slots]
};

} // namespace skein
