// Constants of the rods of a group that step implicitly, node by node: free directions, inertia and damping.
#pragma once

#include "mechanics/kick.hpp"
#include "rod/body_shape.hpp"
#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"

#include <array>
#include <string>
#include <vector>

namespace skein {

class ImplicitRod {
public:
    struct Row {
        std::array<double, 6> free{1, 1, 1, 1, 1, 1};  ///< 0: held; node along lab axes, element along its own
        bool turns_in_lab = false;                     ///< the element's are along lab axes too
        double mass = 0, node_rate = 0;                ///< kg, 1/s
        Vec3d inertia{0, 0, 0};                        ///< kg m^2
        Vec3d rate{0, 0, 0}, rate_by_stretch{0, 0, 0}; ///< damping of the spin, 1/s: by itself and per dilatation
    };

    ImplicitRod(const RodGroup& group, const DampingRates& rates) {
        const int n = group.elements(), slots = group.slots();
        length_ = group.strained() ? 0 : group.body()->reach;
        if (group.strained())
            for (const ElementConstants& e : group.element) length_ += e.rest_length;
        for (int k = 0; k < slots; ++k) {
            Row& row = row_.emplace_back();
            row.mass = nth(group.node_mass, k);
            if (!rates.none()) row.node_rate = nth(rates.node, k);
            hold_end(group, k, row);
            if (k >= n) continue;
            row.inertia = nth(group.element, k).inertia;
            if (!rates.none()) row.rate = nth(rates.element, k);
            if (rates.follow_stretch()) row.rate_by_stretch = nth(rates.element_stretched, k);
        }
        hold_inside(group);
    }

    double length() const { return length_; } ///< m; of a body its reach
    const Row& operator[](int k) const { return nth(row_, k); }

private:
    static void hold_end(const RodGroup& group, int k, Row& row) {
        if (group.strained() && group.holds_node(k)) row.free[0] = row.free[1] = row.free[2] = 0;
        if (group.strained() && group.slides(k)) {
            const Vec3d free = group.free_directions(k);
            row.free[0] = free.x;
            row.free[1] = free.y;
            row.free[2] = free.z;
        }
        if (k == group.elements() || (group.strained() && group.holds_element(k)))
            row.free[3] = row.free[4] = row.free[5] = 0;
    }
    void hold_inside(const RodGroup& group) {
        const Hold& hold = group.spec().hold;
        const int n = group.elements(), nodes = group.nodes();
        const auto hold_axes = [](double* free, const std::string& axes) {
            for (const char axis : axes) free[axis - 'x'] = 0;
        };
        for (const long i : hold.nodes) hold_axes(nth(row_, i < 0 ? nodes + i : i).free.data(), hold.directions);
        for (const long k : hold.elements) {
            Row& row = nth(row_, k < 0 ? n + k : k);
            hold_axes(&row.free[3], hold.axes);
            row.turns_in_lab = hold.axes.size() < 3;
        }
    }

    double length_ = 0;
    std::vector<Row> row_; ///< [slots]
};

} // namespace skein
