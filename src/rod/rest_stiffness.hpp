// Stiffness of a rod at rest by its law.                                                          theory.md (14), (26)
#pragma once

#include "skein/rod/rod_group.hpp"

namespace skein {

/// Divisor of B at rest, at dilatation e. With neo_hookean, B is that at rest already.
inline double bending_divisor(const RodGroup& g, double e) {
    return g.law() == Law::linear || g.law() == Law::neo_hookean ? 1 : e * e * e;
}

/// dn_3/de at rest, N.
inline double axial_stiffness(const RodGroup& g, const ElementConstants& c) {
    if (g.law() == Law::linear) return c.stiffness.z;
    return g.law() == Law::neo_hookean ? c.stiffness.z / (c.rest_stretch * c.rest_stretch)
                                       : c.stiffness.z / c.rest_stretch;
}

/// Dilatation at rest of the cell between elements v and v + 1, round a ring.
inline double rest_dilatation(const RodGroup& g, int v) {
    const VoronoiConstants& c = nth(g.voronoi, v);
    return c.share_before * nth(g.element, v).rest_stretch +
           c.share_after * nth(g.element, (v + 1) % g.elements()).rest_stretch;
}

} // namespace skein
