#include "loads/damping.hpp"
#include "skein/core/index.hpp"

#include <algorithm>

namespace skein {

namespace {

/// Mass of element k in published codes: the mean of its nodes, with the whole end node for end elements; in a ring
/// that of its first node.
double legacy_mass(const RodGroup& group, std::size_t k) {
    const auto& m = group.node_mass;
    if (group.closed() || !group.strained()) return m[k];
    double mass = 0.5 * (m[k] + m[k + 1]);
    if (k == 0) mass += 0.5 * m.front();
    if (k + 2 == m.size()) mass += 0.5 * m.back();
    return mass;
}

Vec3d over(double a, const Vec3d& j) { return {a / j.x, a / j.y, a / j.z}; }

} // namespace

DampingRates damping_rates(const RodGroup& group, std::span<const Damping> damping) {
    DampingRates rates;
    if (std::all_of(damping.begin(), damping.end(), is_filter)) return rates;
    const std::size_t n = to_index(group.elements());
    rates.node.assign(group.node_mass.size(), 0.0);
    rates.element.assign(n, Vec3d{0, 0, 0});
    for (const Damping& d : damping) {
        if (is_filter(d)) continue;
        if (d.kind != DampingKind::uniform && group.strained() && !rates.follow_stretch())
            rates.element_stretched.assign(n, Vec3d{0, 0, 0});
        for (std::size_t i = 0; i < rates.node.size(); ++i)
            if (group.node_mass[i] > 0)
                rates.node[i] += d.kind == DampingKind::physical ? d.translational / group.node_mass[i] : d.rate;
        std::vector<Vec3d>& with_stretch = group.strained() ? rates.element_stretched : rates.element;
        for (std::size_t k = 0; k < n; ++k) {
            const Vec3d& j = group.element[k].inertia;
            switch (d.kind) {
            case DampingKind::uniform:
                rates.element[k] += Vec3d{d.rate, d.rate, d.rate};
                break;
            case DampingKind::legacy:
                with_stretch[k] += over(d.rate * legacy_mass(group, k), j);
                break;
            case DampingKind::physical:
                with_stretch[k] += over(d.rotational, j);
                break;
            case DampingKind::laplacian:
                break;
            }
        }
    }
    return rates;
}

} // namespace skein
