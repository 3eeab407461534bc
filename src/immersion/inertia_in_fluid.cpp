#include "immersion/inertia_in_fluid.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// `borne`: over the rod's own.
InertiaShares<double> shares(double borne) {
    constexpr double least = 0.25; // felt, over the fluid's
    const double felt = std::max(1 - borne, least * borne), added = felt - (1 - borne);
    // Motions that steps of the fluid do not resolve swing up where more of the fluid's inertia than `least` comes back at once.
    const double ratio = added > 0 ? std::min(1.0, least * borne / added) : 1;
    return {borne, felt, added, ratio * std::sqrt(ratio)};
}

/// Markers of one place along a rod.
struct Ring {
    std::uint32_t element;
    double along, place;                 ///< the second from the rod's start, m
    bool off_d1 = false, off_d2 = false; ///< some lie off the axis along d1, d2
};

std::vector<Ring> rings_of(const RodGroup& group, std::span<const RodMarker> markers) {
    std::vector<double> begin(1, 0); // of elements, m
    for (const ElementConstants& e : group.element) begin.push_back(begin.back() + e.rest_length);
    std::vector<Ring> rings;
    for (const RodMarker& m : markers) {
        if (rings.empty() || rings.back().element != m.element || rings.back().along != m.along)
            rings.push_back({m.element, m.along, begin[m.element] + m.along * group.element[m.element].rest_length});
        rings.back().off_d1 |= m.off_d1 != 0, rings.back().off_d2 |= m.off_d2 != 0;
    }
    return rings;
}

/// f(element, share) of the elements between two places along a rod.
template <class F> void for_elements(const RodGroup& group, double from, double to, F&& f) {
    double begin = 0;
    for (std::size_t k = 0; k < group.element.size(); ++k) {
        const double length = group.element[k].rest_length, share = (std::min(to, begin + length) - std::max(from, begin)) / length;
        if (share > 0) f(k, share);
        begin += length;
    }
}

} // namespace

InertiaInFluid::InertiaInFluid(const RodGroup& group, std::span<const RodMarker> markers, double density, bool inner)
    : displaced(density / group.spec().material.density) {
    std::vector<double> mass(group.node_mass.size());
    std::vector<Vec3d> turning(group.element.size());
    const std::vector<Ring> rings = inner ? rings_of(group, markers) : std::vector<Ring>();
    double length = 0;
    for (const ElementConstants& e : group.element) length += e.rest_length;
    for (std::size_t r = 0; r < rings.size(); ++r) {
        const Ring& ring = rings[r];
        const double from = r > 0 ? 0.5 * (rings[r - 1].place + ring.place) : 0,
                     to = r + 1 < rings.size() ? 0.5 * (ring.place + rings[r + 1].place) : length;
        for_elements(group, from, to, [&](std::size_t k, double share) {
            const ElementConstants& e = group.element[k];
            const double of_element = share * density * e.volume,
                         scaled = group.rotary_inertia_scale.empty() ? 1 : group.rotary_inertia_scale[k];
            mass[ring.element] += (1 - ring.along) * of_element;
            mass[ring.element + 1] += ring.along * of_element;
            turning[ring.element] +=
                (share * displaced) * Vec3d{ring.off_d2 ? e.inertia.x / scaled : 0, ring.off_d1 ? e.inertia.y / scaled : 0,
                                            ring.off_d1 || ring.off_d2 ? e.inertia.z : 0};
        });
    }
    if (group.closed()) mass.front() += mass.back(), mass.back() = 0;
    for (std::size_t k = 0; k < mass.size(); ++k)
        of_nodes.push_back(shares(group.node_mass[k] > 0 ? mass[k] / group.node_mass[k] : 0));
    for (std::size_t k = 0; k < turning.size(); ++k) {
        const Vec3d borne = scale(turning[k], group.element[k].inv_inertia);
        const auto x = shares(borne.x), y = shares(borne.y), z = shares(borne.z);
        of_elements.push_back({borne, {x.felt, y.felt, z.felt}, {x.added, y.added, z.added}, {x.returned, y.returned, z.returned}});
    }
}

double InertiaInFluid::least_felt() const {
    double all = 1;
    for (const auto& node : of_nodes) all = std::min(all, node.felt);
    for (const auto& e : of_elements) all = std::min({all, e.felt.x, e.felt.y, e.felt.z});
    return all;
}

} // namespace skein
