// Rods of varying section: scale of the section of a cell, and division of an element's mass. theory.md (4a), (4b)
#pragma once

#include "skein/rod/rod_spec.hpp"

#include <vector>

namespace skein {

/// Scales of the section over that of the scene, as factors of its radius: at the middles of elements [n] and at nodes
/// [n + 1]. The first and last node of a ring are one.
struct SectionScales {
    std::vector<double> element, node;

    bool uniform() const;
};

/// Scales of a section at a node, along d1 and along d2.
struct NodeScales {
    double first, second;
};
/// Share of an element's mass that its first node has. With it the centre of mass is that of the cone between the
/// nodes.
double mass_share_before(const NodeScales& before, const NodeScales& after);

/// Scale by node [n + 1] of the section that represents the cell around it, in an open rod of n >= 2 equal elements. It
/// is the scale of the node at and beside an end whose direction is held.
std::vector<double> cell_scales(const SectionScales& scales, EndKind start, EndKind end);

} // namespace skein
