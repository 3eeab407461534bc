// Share of an element that lies beside a near-parallel other.                                      theory.md (56e)
//   f1 < f2: feet of the other's ends on the line of the element
//   x = (min(1, f2) - max(0, f1))/min(1, f2 - f1)
// The share weighs their contact where vertices end the overlap. Between two free ends of bodies that go on beyond, it
// is smoothed to 1 - x^2 + x^3, from 1 of a contact end by end. Without vertices it is 1. So it has no jump, and its
// kinks cancel with those of neighbours.
#pragma once

#include "contact/compress.hpp"
#include "neighbourhood/exposure.hpp"

namespace skein {

template <class P> struct Overlap {
    P share;
    P foot[2], change[2]; ///< feet of the other's ends, the lower one first; derivative of the share by that foot
};

/// Vertices of eight elements or of one, as masks: at the start and at the end.
template <int W> struct VertexMasks { Mask<W> at[2]; };

/// `same_way`: both elements lead the same way.
template <int W> SKEIN_INLINE Overlap<Pack<W>> overlap_on(const Vec3<Pack<W>>& start, const Vec3<Pack<W>>& edge,
                                                          const Vec3<Pack<W>>& other,
                                                          const Vec3<Pack<W>>& edge_of_other, const Mask<W>& same_way,
                                                          const VertexMasks<W>& vertices,
                                                          const VertexMasks<W>& vertices_of_other) {
    using P = Pack<W>;
    const P zero(0.0), one(1.0), squared = max(dot(edge, edge), P(1e-300)), from = dot(other - start, edge) / squared,
                                 to = from + dot(edge_of_other, edge) / squared;
    Overlap<P> o;
    o.foot[0] = select(same_way, from, to);
    o.foot[1] = select(same_way, to, from);
    const Mask<W> by_foot[2] = {o.foot[0] > zero, o.foot[1] < one},
                  other_joined[2] = {(same_way & vertices_of_other.at[0]) | ((!same_way) & vertices_of_other.at[1]),
                                     (same_way & vertices_of_other.at[1]) | ((!same_way) & vertices_of_other.at[0])};
    Mask<W> at_vertex = zero > zero;
    for (const int i : {0, 1})
        at_vertex = at_vertex | (by_foot[i] & other_joined[i]) | ((!by_foot[i]) & vertices.at[i]);
    const Mask<W> some = vertices.at[0] | vertices.at[1] | vertices_of_other.at[0] | vertices_of_other.at[1];
    const P span = o.foot[1] - o.foot[0], shorter = max(min(one, span), P(1e-300)),
            x = max(zero, (min(one, o.foot[1]) - max(zero, o.foot[0])) / shorter);
    o.share = select(some, select(at_vertex, x, one - x * x * (one - x)), one);
    const P slope = select(some, select(at_vertex, one, x * fms(P(3.0), x, P(2.0))) / shorter, zero),
            by_span = select(span < one, x, zero);
    const auto overlaps = x > zero;
    o.change[0] = select(overlaps, slope * (by_span - select(by_foot[0], one, zero)), zero);
    o.change[1] = select(overlaps, slope * (select(by_foot[1], one, zero) - by_span), zero);
    return o;
}

} // namespace skein
