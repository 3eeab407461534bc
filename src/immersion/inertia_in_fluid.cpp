#include "immersion/inertia_in_fluid.hpp"

#include "immersion/body_surface.hpp"
#include "rod/solids.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace skein {

namespace {

/// `sharp`: all of the surface there is.
InertiaShares<double> shares(double displaced, bool sharp) {
    constexpr double least = 0.25; // effective inertia over the displaced fluid's
    const double effective = std::max(1 - displaced, least * displaced), added = effective - (1 - displaced);
    // Little is returned before it is due, as a delay would pump motions that move no fluid around. theory.md (156a)
    constexpr double little = 0.3 * (1 + 1e-9), early = 1.5;
    if (sharp && added <= little * displaced) return {displaced, effective, added, early};
    // A greater fraction at once would pump motions that steps of the fluid do not resolve. theory.md (88a)
    const double ratio = added > 0 ? std::min(1.0, least * displaced / added) : 1;
    return {displaced, effective, added, ratio * std::sqrt(ratio)};
}

InertiaShares<Vec3d> shares(const Vec3d& displaced, bool sharp) {
    const auto x = shares(displaced.x, sharp), y = shares(displaced.y, sharp), z = shares(displaced.z, sharp);
    return {displaced,
            {x.effective, y.effective, z.effective},
            {x.added, y.added, z.added},
            {x.relaxation, y.relaxation, z.relaxation}};
}

/// Markers of one place along a rod.
struct Ring {
    std::uint32_t element;
    double along, place;                 ///< share of the element, and distance from the rod's start, m
    bool off_d1 = false, off_d2 = false; ///< some markers lie off the axis along d1, d2
};

/// `begin`: distances of nodes from the rod's start, m.
std::vector<Ring> rings_of(std::span<const RodMarker> markers, std::span<const double> begin) {
    std::vector<Ring> rings;
    for (const RodMarker& m : markers) {
        if (rings.empty() || rings.back().element != m.element || rings.back().along != m.along)
            rings.push_back(
                {m.element, m.along, begin[m.element] + m.along * (begin[m.element + 1] - begin[m.element])});
        rings.back().off_d1 |= m.off_d1 != 0;
        rings.back().off_d2 |= m.off_d2 != 0;
    }
    return rings;
}

/// Inertia of displaced fluid, of nodes, kg, and of elements about d1, d2, d3, kg m^2.
struct Displaced {
    std::vector<double> mass;
    std::vector<Vec3d> turning;
};

/// Own inertia of an element about d1, d2 and d3 without what `rotary_inertia_for_dt` adds, kg m^2.
Vec3d unscaled_inertia(const RodGroup& group, std::size_t k) {
    const Vec3d& own = group.element[k].inertia;
    const double scaled = group.rotary_inertia_scale.empty() ? 1 : group.rotary_inertia_scale[k];
    return {own.x / scaled, own.y / scaled, own.z};
}

/// Adds what sharp surfaces move, `share` of an element. Fluid moves with all of it, and about all of its axes. A plate
/// has no edges along d2, so that no fluid moves with its turning about d1, and that about d3 moves the fluid along d2
/// alone.
void add_within(const RodGroup& group, std::size_t k, double density, double share, bool spans, Displaced& all) {
    const double half = share * (0.5 * density * group.element[k].volume);
    all.mass[k] += half;
    all.mass[k + 1] += half;
    const Vec3d own = unscaled_inertia(group, k);
    all.turning[k] += (share * (density / group.spec().material.density)) * (spans ? Vec3d{0, own.y, own.y} : own);
}

/// Adds what rings of markers move, but for the parts of elements that sharp surfaces move.
void add_around(const RodGroup& group, std::span<const RodMarker> markers, double density,
                const std::function<double(std::size_t element)>& sharp, Displaced& all) {
    std::vector<double> begin(1, 0);
    for (const ElementConstants& e : group.element) begin.push_back(begin.back() + e.rest_length);
    const std::vector<Ring> rings = rings_of(markers, begin);
    std::size_t k = 0;
    for (std::size_t r = 0; r < rings.size(); ++r) {
        const Ring& ring = rings[r];
        const bool last = r + 1 == rings.size();
        const double from = r > 0 ? 0.5 * (rings[r - 1].place + ring.place) : 0,
                     to = last ? begin.back() : 0.5 * (ring.place + rings[r + 1].place);
        for (; k < group.element.size() && begin[k] < to; ++k) { // elements around the ring
            const ElementConstants& e = group.element[k];
            const double share =
                (1 - sharp(k)) * ((std::min(to, begin[k + 1]) - std::max(from, begin[k])) / e.rest_length);
            const Vec3d own = unscaled_inertia(group, k);
            all.mass[ring.element] += (1 - ring.along) * share * density * e.volume;
            all.mass[ring.element + 1] += ring.along * share * density * e.volume;
            all.turning[ring.element] +=
                (share * (density / group.spec().material.density)) *
                Vec3d{ring.off_d2 ? own.x : 0, ring.off_d1 ? own.y : 0, ring.off_d1 || ring.off_d2 ? own.z : 0};
            if (begin[k + 1] > to) break; // the next ring has the rest of this element
        }
    }
}

} // namespace

InertiaInFluid::InertiaInFluid(const RodGroup& group, std::span<const RodMarker> markers, double density, bool inner,
                               std::span<const double> sharp, bool spans)
    : density_ratio(density / group.spec().material.density) {
    if (const BodyShape* body = group.body()) {
        take_body(*body, markers, density, inner);
        return;
    }
    Displaced fluid{std::vector<double>(group.node_mass.size()), std::vector<Vec3d>(group.element.size())};
    const auto sharp_share = [&](std::size_t k) { return sharp.empty() ? 0 : share_at(sharp, k, 0.5); };
    if (inner) {
        for (std::size_t k = 0; k < group.element.size(); ++k)
            if (const double share = sharp_share(k); share > 0) add_within(group, k, density, share, spans, fluid);
        add_around(group, markers, density, sharp_share, fluid);
    }
    std::vector<double>& mass = fluid.mass;
    if (group.closed()) {
        mass.front() += mass.back();
        mass.back() = 0;
    }
    for (std::size_t i = 0; i < mass.size(); ++i)
        of_nodes.push_back(
            shares(group.node_mass[i] > 0 ? mass[i] / group.node_mass[i] : 0, !sharp.empty() && sharp[i] == 1));
    for (std::size_t i = 0; i < fluid.turning.size(); ++i)
        of_elements.push_back(shares(scale(fluid.turning[i], group.element[i].inv_inertia), sharp_share(i) == 1));
}

InertiaInFluid::InertiaInFluid(const BodyShape& body, double density, bool has_inner) : sharp(true) {
    const DisplacedVolume displaced = displaced_volume(body);
    const AddedInertia around = added_inertia(displaced);
    const double mass = density * displaced.volume;
    density_ratio = mass / body.mass;
    buoyancy_centre = displaced.centre;
    const SymmetricMatrix j = times(density, displaced.inertia);
    if (has_inner) inner = {mass, displaced.centre, j};
    // Kicks feel the inertia that accelerations of this step will have had when the flow has answered. theory.md (145)
    const auto of = [&](double own, double of_fluid, double times) {
        constexpr double least = 0.25; // of the displaced fluid's
        const double displaced_share = has_inner ? of_fluid / own : 0,
                     effective = std::max(1 - displaced_share + (1 + times) * of_fluid / own, least * of_fluid / own);
        return InertiaShares<double>{displaced_share, effective, effective - (1 - displaced_share), 1};
    };
    of_nodes.push_back(of(body.mass, mass, (around.linear.x + around.linear.y + around.linear.z) / 3));
    const auto x = of(body.inertia.x, j.xx, around.angular.x), y = of(body.inertia.y, j.yy, around.angular.y),
               z = of(body.inertia.z, j.zz, around.angular.z);
    of_elements.push_back({{x.displaced, y.displaced, z.displaced},
                           {x.effective, y.effective, z.effective},
                           {x.added, y.added, z.added},
                           {1, 1, 1}});
}

void InertiaInFluid::take_body(const BodyShape& body, std::span<const RodMarker> markers, double density,
                               bool has_inner) {
    const DisplacedVolume displaced = displaced_volume(body);
    density_ratio = density * displaced.volume / body.mass;
    buoyancy_centre = displaced.centre;
    if (has_inner) inner = {density * displaced.volume, displaced.centre, times(density, displaced.inertia)};
    Vec3d off{0, 0, 0}; // largest distances of markers from the axes
    for (const RodMarker& m : markers)
        off = {std::max(off.x, std::hypot(m.off_d2, m.off_d3)), std::max(off.y, std::hypot(m.off_d3, m.off_d1)),
               std::max(off.z, std::hypot(m.off_d1, m.off_d2))};
    const auto turns = [&](double distance) { return distance > 1e-9 * body.reach ? 1.0 : 0.0; };
    const Vec3d t{turns(off.x), turns(off.y), turns(off.z)};
    SymmetricMatrix& j = inner.inertia;
    j = {t.x * j.xx, t.y * j.yy, t.z * j.zz, t.x * t.y * j.xy, t.x * t.z * j.xz, t.y * t.z * j.yz};
    of_nodes.push_back(shares(inner.mass / body.mass, false));
    of_elements.push_back(shares(Vec3d{j.xx / body.inertia.x, j.yy / body.inertia.y, j.zz / body.inertia.z}, false));
}

double InertiaInFluid::least_effective() const {
    double all = 1;
    for (const auto& node : of_nodes) all = std::min(all, node.effective);
    for (const auto& e : of_elements) all = std::min({all, e.effective.x, e.effective.y, e.effective.z});
    return all;
}

} // namespace skein
