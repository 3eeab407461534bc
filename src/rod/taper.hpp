// Rods whose section changes along them: what stands for the section of a cell, and where an element's mass lies.
//                                                                                                       theory.md (4a),
//                                                                                                       (4b)
#pragma once

#include "skein/rod/rod_spec.hpp"

#include <vector>

namespace skein {

/// Sections over that which a scene gives, as factors of its radius: at the middles of elements [n] and at nodes [n +
/// 1], of which the first of a ring is the last too.
struct SectionScales {
    std::vector<double> element, node;

    bool uniform() const;
};

/// Of a section at a node, along d1 and along d2.
struct NodeScales {
    double first, second;
};
/// Part of an element's mass that the first of its nodes has: with it the centre of mass is that of the cone between
/// the nodes.
double mass_share_before(const NodeScales& before, const NodeScales& after);

/// By node [n + 1]: scale of the section that stands for the cell around it in an open rod of n >= 2 equal elements. At
/// and beside an end that is held in its turn, that of the section at the node.
std::vector<double> cell_scales(const SectionScales& scales, EndKind start, EndKind end);

} // namespace skein
