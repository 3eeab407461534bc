// Weights of contacts with boxes that neighbouring elements share at a vertex.                     theory.md (59e)
//   w = u^2 (3 - 2 u),  u = (1 - x/D)/2 clamped to [0, 1]
//   x: place nearest to the box on the mean tangent of both neighbours, through the vertex, outwards
//   D: a share of the shorter neighbour's length, by which an element reaches beyond its vertices
// Neighbours have the same x but for its sign, so their weights sum to 1. A contact beyond the vertex is at
// s = 1 + x/|e|, where a straight neighbour sees it too. At a corner touched from outside both see the vertex. Where
// neighbours are bent by a fair part of the angle at which they cross the other, x and s disagree. So x is held within
// D of (s - 1)|e|, s clamped to [0, 1]. At a larger bend, or a sine below 0.25, a contact would go from one element to
// the next within a step or two. There w goes over to 1, and each element pushes by itself. Contacts of elements with
// each other have energies at vertices instead (vertex_terms.hpp).
#pragma once

#include "contact/broad_phase.hpp"
#include "contact/compress.hpp"
#include "core/closest_points.hpp"

namespace skein {

constexpr double shallow =
    0.25; ///< sine of the angle below which elements begin to push by themselves near their vertices
constexpr double held = 0.25;  ///< share of D by which neighbours may disagree on a contact's place before shares fade
constexpr double blend = 0.05; ///< sine of the angle below which elements meet at both ends of their overlap as well

/// Reach of an element beyond its vertices over its length. At its end shares are 0, whatever is rounded.
constexpr double seen_beyond(double reach) { return (1 + held) * reach * (1 + 1e-6); }

/// Side of a contact on its element: -1 near a vertex at the start, 1 near one at the end, 0 elsewhere, where no
/// neighbour has a share.
inline std::int8_t vertex_side(double s, unsigned vertices, double reach) {
    const double near = seen_beyond(reach);
    return static_cast<std::int8_t>(static_cast<int>((vertices & at_end) && s > 1 - near) -
                                    static_cast<int>((vertices & at_start) && s < near));
}

/// Vertices of both elements of a pair: of the first as bits of Vertex, of the second two bits higher.
inline std::uint8_t vertices_of_pair(const Exposure& bodies, Pair pair) {
    return static_cast<std::uint8_t>(bodies.vertices[pair.a] | bodies.vertices[pair.b] << 2);
}
/// Shares of eight elements, the first or second of pairs, with what reaches beyond vertices.
SKEIN_INLINE ShareRange<Pack<8>> range_of(const std::uint8_t* vertices, int second, double reach) {
    const unsigned starts = bits_of_bytes(vertices, 2 * second), ends = bits_of_bytes(vertices, 2 * second + 1);
    return {where_set<8>(starts, -reach), Pack<8>(1.0) + where_set<8>(ends, reach)};
}

/// A weight in steps of 2^-20, so that sums of them are the same in any order.
template <int W> SKEIN_INLINE Pack<W> in_steps(Pack<W> weight) {
    constexpr double large = 1.5 * 4294967296.0; // whose last place is such a step
    return (weight + Pack<W>(large)) - Pack<W>(large);
}

template <class P> struct VertexShare {
    P weight;
    P beyond; ///< distance of the contact beyond the vertex over the element's length, at least 0
    P bend;   ///< sine of half the angle between both elements, over D, 1/m
};

/// `to_vertex`: way from the contact to the vertex over the element's length, below 0 beyond. `edge`, `beyond`: of the
/// element and of its neighbour, both leading away from the vertex. `on_box`: nearest point of the box. Cost: 60 flop,
/// of which six divisions and roots.
template <int W> SKEIN_INLINE VertexShare<Pack<W>> vertex_share(double reach, Pack<W> to_vertex,
                                                                const Vec3<Pack<W>>& vertex, const Vec3<Pack<W>>& edge,
                                                                const Vec3<Pack<W>>& beyond,
                                                                const Vec3<Pack<W>>& on_box) {
    using P = Pack<W>;
    const P zero(0.0), half(0.5), one(1.0), tiny(1e-60);
    const P length = max(norm(edge), tiny), next = max(norm(beyond), tiny), inverse = one / (length * next),
            per_length = next * inverse, per_next = length * inverse,
            per_zone = P(1 / reach) * max(per_length, per_next);
    const Vec3<P> outwards = per_next * beyond - per_length * edge;
    // The least of |vertex + y outwards - on_box|^2; where neighbours are folded together, which a trifle decides, y is
    // near 0.
    const P squared = dot(outwards, outwards), y = -dot(outwards, vertex - on_box) / max(P(1 + 2.5e-5) * squared, tiny),
            within = -to_vertex * (length * per_zone),
            x = within + max(min(fma(y, sqrt(squared) * per_zone, -within), P(held)), P(-held));
    const P u = min(max(half - half * x, zero), one);
    return {u * u * (P(3.0) - (u + u)), min(max(x, zero), one) * (P(reach) * min(one, next * per_length)),
            sqrt(max(fnma(P(0.25), squared, one), zero)) * per_zone};
}

/// c of (59e): 1 where neighbours share contacts, 0 where each pushes by itself. `bend`: that of VertexShare times the
/// sum of radii.
template <int W> SKEIN_INLINE Pack<W> sharing(Pack<W> sine_squared, Pack<W> bend) {
    using P = Pack<W>;
    const P zero(0.0), one(1.0), steep = min(sine_squared * P(1 / (shallow * shallow)), one),
                                 apart = min(bend / max(sine_squared, P(1e-30)), one),
                                 bent = max(apart - P(held), zero) * P(1 / (1 - held));
    return steep * (P(2.0) - steep) * (one - bent * bent * (P(3.0) - (bent + bent)));
}

} // namespace skein
