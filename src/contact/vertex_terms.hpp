// Energies of vertices, less of contacts of the elements that share them.                                    theory.md
// (56c), (56d)
//   Of each pair, with the energy phi of its normal spring at the nearest points of two elements:
//   E = phi(e, f) - sum_v c_v phi(v, f)/2 - sum_w c_w phi(e, w)/2 + sum_vw c_v c_w phi(v, w)/4
//   v, w: vertices of e and f, as balls of their radii; each belongs to two elements, which take half of it each
// So a contact beside a vertex, which the neighbour sees at the vertex, is counted once: of both neighbours and the
// vertex between them one is left. Forces are minus the gradient of E, with the derivatives of c. With the bend b of
// both tangents at v, towards f, and x = (Q/S - 1/8)/(3/8) clamped to [0, 1]:
//   c = p (2 - p) (1 - x^2 (3 - 2 x)),  p = min(1, S/0.25^2),  S = sin^2 of the angle of e and f,  Q = 2 b.A/(l + l')
//   A from v to its foot on f;  Q/S = 1: the rod lies along the other one, and each of its elements pushes by itself
// Cost: 60 flop for each vertex and each pair of them; 100 more where c changes.
#pragma once

#include "contact/response.hpp"
#include "contact/vertices.hpp"

namespace skein {

/// An element of a pair that touches.
template <class P> struct ElementAtVertices {
    Vec3<P>
        node[4]; ///< of the neighbour before, its start, its end, of the neighbour behind; anywhere where there is none
    P share;     ///< where on it the nearest point is
    P joined[2]; ///< 1 where there is a vertex at its start, at its end, which may touch; else 0
};

template <class P> struct VertexTerms {
    P weight{1.0};            ///< share of the nearest points, with which they act
    P share[2] = {0.0, 0.0};  ///< where these are on both elements, beyond vertices where the contact is
    Vec3<P> apart{};          ///< between them, from the first
    P energy{0.0};            ///< E beside that, J
    P normal{0.0};            ///< normal force of the pair beside that of the nearest points, N; scaled
    P scale{1.0};             ///< 1 - a of (56b), which multiplies all of E
    Vec3<P> force[2][4] = {}; ///< on the nodes of ElementAtVertices, N; scaled
    unsigned turns = 0;       ///< lanes in which nodes of neighbours have some
};

constexpr double least_lying = 0.125; ///< Q/S above which a rod begins to lie along the other one
constexpr double most_lying = 0.5;    ///< and from where on it does: two rods wound round each other do from 1/2 on
/// A bent rod is taken for straight beyond a vertex while it bends away by half of this, over the sum of radii.
constexpr double straight = 1.0 / 1024;

/// `from_first`: from the nearest point of the first element to that of the second. Vertices of the second element
/// count where `both`.
template <int W, bool both>
SKEIN_INLINE VertexTerms<Pack<W>> vertex_terms(ContactNormal kind, Pack<W> stiffness, Pack<W> radii,
                                               const Vec3<Pack<W>>& from_first, Pack<W> sine_squared_of_both,
                                               const ElementAtVertices<Pack<W>> (&element)[2]) {
    using P = Pack<W>;
    const P zero(0.0), half(0.5), one(1.0), tiny(1e-150), none(1e-300);
    const bool hertz = kind == ContactNormal::hertz;
    const P distance = norm(from_first);
    struct Spring {
        P normal, energy;
    };
    const auto spring = [&](P at_distance) -> Spring {
        const P depth = max(radii - at_distance, zero), root = hertz ? sqrt(depth) : one,
                normal = stiffness * root * depth;
        return {normal, P(hertz ? 0.4 : 0.5) * normal * depth};
    };
    const Vec3<P> edge[2] = {element[0].node[2] - element[0].node[1], element[1].node[2] - element[1].node[1]};
    const P squared[2] = {max(dot(edge[0], edge[0]), none), max(dot(edge[1], edge[1]), none)};
    const P inverse_squared[2] = {one / squared[0], one / squared[1]},
            own_length[2] = {sqrt(squared[0]), sqrt(squared[1])};
    const P sine_squared =
        select(min(squared[0], squared[1]) > none, sine_squared_of_both, one); // a point is across everything
    const P inverse_sine = one / max(sine_squared, P(1e-30)),
            steep = min(sine_squared * P(1 / (shallow * shallow)), one), crossing = steep * (P(2.0) - steep),
            per_sine = select(steep < one, (P(2.0) - (steep + steep)) * P(1 / (shallow * shallow)), zero);

    VertexTerms<P> out;
    struct Corner {
        Vec3<P> apart, inwards, outwards,
            bend; ///< to the foot; tangents of the element and of its neighbour, from it; theirs apart
        P foot, on_line, share, share_of_crossing, per_lying, lying, longer, curved, energy;
        P here; // 1 where the element's nearest point is there
    } corner[2][2];
    Vec3<P> along[2];        // the edge, of length 1
    P way[2] = {zero, zero}; // how far the neighbour goes on towards the other element, along the edge
    P goes[2];               // 1 where the nearest point may go on along the edge
    P inverse_length[2];
    for (const int i : {0, 1}) {
        inverse_length[i] = own_length[i] * inverse_squared[i];
        along[i] = inverse_length[i] * edge[i];
        goes[i] = select((element[i].share > zero) & (element[i].share < one), one, zero);
    }
    for (int i = 0; i < 1 + both; ++i)
        for (const int j : {0, 1}) {
            const ElementAtVertices<P>&e = element[i], &o = element[1 - i];
            Corner& c = corner[i][j];
            const Vec3<P>& at = e.node[1 + j];
            const Vec3<P> from_vertex = e.node[3 * j] - at, from = at - o.node[1];
            const P next = max(norm(from_vertex), tiny), both_lengths = own_length[i] + next,
                    inverse = one / (next * both_lengths); // one division for two
            c.longer = both_lengths * inverse;
            c.curved = P(2.0) * (next * inverse);
            c.inwards = j ? along[i] : -along[i];
            c.outwards = c.longer * from_vertex;
            c.bend = c.outwards - c.inwards;
            const P free = dot(from, edge[1 - i]) * inverse_squared[1 - i];
            c.foot = clamp01(free);
            c.on_line = select((free > zero) & (free < one), inverse_squared[1 - i], zero);
            c.apart = fma(c.foot, edge[1 - i], -from);
            const P distance_here = norm(c.apart);
            c.lying = c.curved * dot(c.bend, c.apart);
            const P x = clamp01((c.lying * inverse_sine - P(least_lying)) * P(1 / (most_lying - least_lying))),
                    rest = one - x * x * (P(3.0) - (x + x));
            c.share_of_crossing = e.joined[j] * rest;
            c.share = c.share_of_crossing * crossing;
            c.per_lying = -(P(6 / (most_lying - least_lying)) * e.joined[j] * crossing * x * (one - x)) * inverse_sine;
            const Spring s = spring(distance_here);
            c.energy = s.energy;
            // E = -c phi/2 of this vertex and the other element.
            const P pull = half * c.share * s.normal;
            const Vec3<P> force = (pull / max(distance_here, tiny)) * c.apart;
            out.energy -= half * c.share * s.energy;
            out.normal -= pull;
            out.force[i][1 + j] += force;
            out.force[1 - i][1] -= (one - c.foot) * force;
            out.force[1 - i][2] -= c.foot * force;
            const P beyond = max(min(dot(c.inwards, c.apart), dot(c.outwards, c.apart)), zero);
            c.here = select(j ? e.share >= one : e.share <= zero, e.joined[j], zero);
            way[i] += c.here * c.share * (j ? beyond : -beyond);
            goes[i] += c.here;
        }
    P slope[2][2]; // of the energy over each c
    for (int i = 0; i < 1 + both; ++i)
        for (const int j : {0, 1}) slope[i][j] = -half * corner[i][j].energy;
    if constexpr (both)
        for (const int j : {0, 1})
            for (const int k : {0, 1}) {
                const Vec3<P> apart = element[1].node[1 + k] - element[0].node[1 + j];
                const P distance_here = norm(apart), shares = P(0.25) * corner[0][j].share * corner[1][k].share;
                const Spring s = spring(distance_here);
                const P push = shares * s.normal;
                const Vec3<P> force = (push / max(distance_here, tiny)) * apart;
                out.energy += shares * s.energy;
                out.normal += push;
                out.force[0][1 + j] -= force;
                out.force[1][1 + k] += force;
                slope[0][j] += P(0.25) * corner[1][k].share * s.energy;
                slope[1][k] += P(0.25) * corner[0][j].share * s.energy;
            }
    P per_angle(0.0); // of the energy over S
    auto changes = zero > zero;
    for (int i = 0; i < 1 + both; ++i)
        for (const int j : {0, 1}) {
            const Corner& c = corner[i][j];
            const P over_lying = slope[i][j] * c.per_lying,
                    over_crossing = slope[i][j] * c.share_of_crossing * per_sine;
            per_angle += over_crossing - over_lying * c.lying * inverse_sine;
            changes =
                changes | (over_lying < zero) | (over_lying > zero) | (over_crossing < zero) | (over_crossing > zero);
        }
    if (any(changes)) {
        out.turns = bits_of(changes);
        for (int i = 0; i < 1 + both; ++i)
            for (const int j : {0, 1}) {
                const Corner& c = corner[i][j];
                const int o = 1 - i;
                const P weight = slope[i][j] * c.per_lying; // dE = weight dQ,  Q = curved bend.apart
                const P bent = dot(c.bend, c.apart), by_length = half * c.curved * c.curved * bent;
                const Vec3<P> of_next = (c.curved * c.longer) * (c.apart - dot(c.apart, c.outwards) * c.outwards) -
                                        by_length * c.outwards,
                              of_inner =
                                  (c.curved * inverse_length[i]) * (c.apart - dot(c.apart, c.inwards) * c.inwards) +
                                  by_length * c.inwards;
                const P along = dot(c.bend, edge[o]) * c.on_line;
                const Vec3<P> of_foot = c.curved * (c.bend - along * edge[o]), of_edge = (c.curved * along) * c.apart;
                out.force[i][3 * j] -= weight * of_next;
                out.force[i][2 - j] -= weight * of_inner;
                out.force[i][1 + j] += weight * (of_next + of_inner + of_foot);
                out.force[o][1] -= weight * ((one - c.foot) * of_foot + of_edge);
                out.force[o][2] -= weight * (c.foot * of_foot - of_edge);
            }
        const P product = dot(edge[0], edge[1]),
                both_squared = P(2.0) * (product * inverse_squared[0]) * inverse_squared[1] * per_angle;
        for (const int i : {0, 1}) { // S = 1 - (e1.e2)^2/(e1^2 e2^2)
            const Vec3<P> turn = both_squared * (edge[1 - i] - (product * inverse_squared[i]) * edge[i]);
            out.force[i][2] += turn;
            out.force[i][1] -= turn;
        }
    }
    const P near = max(one - sine_squared * P(1 / (blend * blend)), zero);
    out.scale = one - near * near;
    // The nearest point beyond vertices, where neighbours have it: a straight one sees it in the same place.
    const P cosine = dot(along[0], along[1]), inverse = one / max(sine_squared, P(shallow * shallow)),
            both_go = goes[0] * goes[1];
    Vec3<P> apart = from_first;
    P beyond_distance = distance;
    out.share[0] = element[0].share;
    out.share[1] = element[1].share;
    if (const auto goes_on = (abs(way[0]) > zero) | (abs(way[1]) > zero); any(goes_on)) {
        const P per_straight = one / (P(straight) * radii);
        P there[2], bends(one); // how far the tangents lead over how far bent rods are beside them, to the fourth power
        for (const int i : {0, 1}) {
            there[i] = goes[i] * select(both_go > zero, (way[i] + cosine * way[1 - i]) * inverse, way[i]);
            P curvature(0.0); // of the rod beyond its vertex, squared
            for (const int j : {0, 1})
                if (i < 1 + both) {
                    const Corner& c = corner[i][j];
                    curvature += c.here * (c.curved * c.curved) * dot(c.bend, c.bend);
                }
            const P bent = there[i] * there[i] * per_straight;
            bends = max(bends, bent * bent * curvature);
        }
        const P part = one / sqrt(sqrt(bends));
        for (const int i : {0, 1}) {
            const P &share = element[i].share, s = share + part * there[i] * inverse_length[i];
            there[i] = select(share >= one, max(s, one), select(share <= zero, min(s, zero), clamp01(s)));
        }
        const Vec3<P> between_them =
            fma(there[1], edge[1], element[1].node[1]) - fma(there[0], edge[0], element[0].node[1]);
        const P distance_there = norm(between_them);
        const auto nearer = goes_on & (distance_there < distance);
        apart = select(nearer, between_them, from_first);
        beyond_distance = select(nearer, distance_there, distance);
        for (const int i : {0, 1}) out.share[i] = select(nearer, there[i], out.share[i]);
    }
    const Spring own = spring(distance), whole = spring(beyond_distance);
    const P left = max(own.normal + out.normal, zero);
    out.weight = min(left / max(whole.normal, none), one);
    out.apart = apart;
    // The nearest points act with the weight; what they take of E is given back.
    const auto give = [&](const P& force, const Vec3<P>& way_of_it, const P& length, const P& s, const P& t) {
        const Vec3<P> on_first = (force / max(length, tiny)) * way_of_it;
        out.force[0][1] -= (one - s) * on_first;
        out.force[0][2] -= s * on_first;
        out.force[1][1] += (one - t) * on_first;
        out.force[1][2] += t * on_first;
    };
    give(own.normal, from_first, distance, element[0].share, element[1].share);
    give(-(out.weight * whole.normal), apart, beyond_distance, out.share[0], out.share[1]);
    out.energy += own.energy - out.weight * whole.energy;
    out.normal = out.scale * (left - out.weight * whole.normal);
    for (auto& of_element : out.force)
        for (Vec3<P>& force : of_element) force = out.scale * force;
    return out;
}

} // namespace skein
