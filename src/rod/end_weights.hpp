// Gregory's weights of the three cells, or of the three node masses, beside an end. With them sums along the rod lose
// their error term of second order at the end. A free rod then has the moments of inertia of its length. theory.md, end
// of section 3
#pragma once

#include "skein/core/index.hpp"
#include "skein/rod/rod_spec.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace skein {

/// Ratios to the weights of the trapezoid rule, 1/2, 1, 1: lengths 3/8, 7/6 and 23/24 of an element.
inline constexpr std::array<double, 3> gregory_weight = {3.0 / 4, 7.0 / 6, 23.0 / 24};

/// True for rods whose ends may have these weights: uniform, open, straight at rest, and not reproducing published
/// results. In a rod that is curved at rest the end's error term has either sign against that of the inner cells.
inline bool takes_end_weights(const RodSpec& spec) {
    const auto published = [](EndKind end) { return end == EndKind::clamped_frozen; };
    return spec.shape.end_weights == EndWeights::gregory && !spec.body && !spec.shape.closed &&
           spec.shape.elements >= 6 && spec.shape.length_profile.empty() && spec.section.taper == 1 &&
           spec.section.profile.empty() && zero(spec.shape.rest_curvature) &&
           spec.shape.rest_curvature_profile.empty() && spec.material.law != Law::elastica && !published(spec.start) &&
           !published(spec.end);
}
/// Moment and deflection are odd at a pinned end: sums of their squares have no error term there.
inline bool weighs_cells(EndKind end) { return end != EndKind::pinned; }
/// Deflections begin with the square of the distance at a clamp: masses there have no error term.
inline bool weighs_masses(EndKind end) { return end == EndKind::free; }

/// Calls f(node, weight) beside each end for which weighs(end) is true.
template <class Weighs, class F> void with_end_weights(const RodSpec& spec, Weighs&& weighs, F&& f) {
    if (!takes_end_weights(spec)) return;
    const std::size_t n = to_index(spec.shape.elements);
    for (std::size_t i = 0; i < gregory_weight.size(); ++i) {
        if (weighs(spec.start)) f(i, gregory_weight[i]);
        if (weighs(spec.end)) f(n - i, gregory_weight[i]);
    }
}

/// Largest 1/m + 1/m' of an element, m and m' being its parts of the masses of its nodes, over that of halves of its
/// mass. Nodes beside a free end are divided among their elements so that it is small. theory.md (26)
constexpr double inverse_mass_of_ends() {
    // share of the element's mass that goes to its node farther from the end
    constexpr double inner[] = {0.6835, 0.4855, 0.5};
    double most = 0, outer = 0.5 * gregory_weight[0];
    for (std::size_t k = 0; k < 3; ++k) {
        most = std::max(most, 0.25 * (1 / outer + 1 / inner[k]));
        if (k < 2) outer = gregory_weight[k + 1] - inner[k];
    }
    return most;
}

} // namespace skein
