// Which free top a group's elements are, as a template argument.
#pragma once

#include "rod/drift.hpp"
#include "rod/elastica.hpp"

namespace skein {

/// Calls f(Top{}) with the drift for the group's section.
template <class F> auto with_top(const RodGroup& group, F&& f) {
    if (group.law() == Law::elastica) return f(PlainTop{});
    const Section& s = group.spec().section;
    if (s.kind == SectionKind::circular || s.radius == s.radius_2) return f(CircularTop{});
    // I1 = pi/4 a b^3 is the smaller one where the semi-axis b along d2 is the shorter.
    return s.radius_2 < s.radius ? f(EllipticTop<0>{}) : f(EllipticTop<1>{});
}

} // namespace skein
