// Terms of vertices in the energy of contacts that neighbouring elements share.         theory.md (56c), (56d), (56f)
//   E = phi(e, f) - sum_v c_v phi(v, f)/2 - sum_w c_w phi(e, w)/2 + sum_vw c_v c_w phi(v, w)/4
//   phi: energy of the normal spring at the nearest points of two elements;  v, w: vertices of e and f, as balls of
//   their radii; each belongs to two elements, which take half of it each
// So a contact at a vertex, which both neighbours see, is counted once: of both neighbours and the vertex one is left.
// Forces are minus the gradient of E, with the derivatives of c:
//   c = p (2 - p) (1 - x^2 (3 - 2 x)),  p = min(1, S/0.25^2),  S = sin^2 of the angle of e and f
//   x = (Q/S - 1/8)/(3/8) clamped to [0, 1],  Q = 2 b.A/(l + l'),  b the bend of both tangents at v, towards f
//   A from v to its foot on f;  Q/S = 1: the rod lies along the other one, and each of its elements pushes by itself
// Cost: 60 flop for each vertex and each pair of them; 100 more where c changes.
#pragma once

#include "contact/response.hpp"
#include "contact/vertices.hpp"

namespace skein {

/// An element of a pair that touches. Of one that may touch with a vertex at one end alone `at_end` says with which,
/// and node[0] is that neighbour's.
template <int W> struct ElementAtVertices {
    using P = Pack<W>;
    Vec3<P> node[4]; ///< node of the neighbour before, start, end, node of the neighbour after; any where there is none
    P share;         ///< share of the nearest point
    P joined[2];     ///< 1 where there is a vertex at its start, at its end, which may touch; else 0
    Mask<W> at_end;  ///< its one vertex is at its end
};

template <class P> struct VertexTerms {
    P weight{1.0};            ///< share of the nearest points, with which they act
    P share[2] = {0.0, 0.0};  ///< shares of the nearest points, beyond vertices where the contact is
    Vec3<P> apart{};          ///< between them, from the first
    P energy{0.0};            ///< E beside that, J
    P normal{0.0};            ///< normal force of the pair beside that of the nearest points, N; scaled
    P scale{1.0};             ///< 1 - a of (56b), which multiplies all of E
    Vec3<P> force[2][4] = {}; ///< on the nodes of ElementAtVertices, N; scaled
    unsigned turns = 0;       ///< lanes in which nodes of neighbours have some
};

/// A bent rod is taken for straight beyond a vertex while it bends away by half of this, over the sum of radii.
constexpr double straight = 1.0 / 1024;

namespace detail {

/// Stages of vertex_terms(): vertices, pairs of vertices, changes of the shares c, the nearest points beyond vertices.
/// Vertices that cannot touch have no terms: to leave them out changes no bit.
template <int W, int vertices_1, int vertices_2> class VertexStages {
public:
    using P = Pack<W>;
    using Elements = const ElementAtVertices<W> (&)[2];

    SKEIN_INLINE VertexStages(ContactNormal kind, P stiffness, P radii, P sine_squared_of_both, Elements element,
                              VertexTerms<P>& out)
        : out_(out), element_(element), hertz_(kind == ContactNormal::hertz), stiffness_(stiffness), radii_(radii) {
        const P zero(0.0), one(1.0), none(1e-300);
        for (const int i : {0, 1}) {
            edge_[i] = element[i].node[2] - element[i].node[1];
            squared_[i] = max(dot(edge_[i], edge_[i]), none);
            inverse_squared_[i] = one / squared_[i];
            length_[i] = sqrt(squared_[i]);
            inverse_length_[i] = length_[i] * inverse_squared_[i];
            along_[i] = inverse_length_[i] * edge_[i];
            displacement_[i] = zero;
            goes_[i] = select((element[i].share > zero) & (element[i].share < one), one, zero);
        }
        sine_squared_ = select(min(squared_[0], squared_[1]) > none, sine_squared_of_both, one); // a point: across all
        inverse_sine_ = one / max(sine_squared_, P(1e-30));
        const P steep = min(sine_squared_ * P(1 / (shallow * shallow)), one);
        crossing_ = steep * (P(2.0) - steep);
        per_sine_ = select(steep < one, (P(2.0) - (steep + steep)) * P(1 / (shallow * shallow)), zero);
    }

    /// -c phi/2 of each vertex and the other element.
    SKEIN_INLINE void add_vertices() {
        const P zero(0.0), half(0.5), one(1.0);
        for_vertices([&]<int i, int j>() __attribute__((always_inline)) {
            Corner& c = corner_[i][j];
            describe<i, j>(c);
            const P distance = norm(c.apart);
            const Spring s = spring(distance);
            const P pull = half * c.share * s.normal;
            const Vec3<P> force = (pull / max(distance, tiny())) * c.apart;
            out_.energy -= half * c.share * s.energy;
            out_.normal -= pull;
            add_at_vertex<i, j>(force);
            out_.force[1 - i][1] -= (one - c.foot) * force;
            out_.force[1 - i][2] -= c.foot * force;
            slope_[i][j] = -half * s.energy;
            const P beyond = max(min(dot(c.inwards, c.apart), dot(c.outwards, c.apart)), zero);
            displacement_[i] += c.here * c.share * at_side<i, j>(-beyond, beyond);
            goes_[i] += c.here;
        });
    }

    /// c_v c_w phi/4 of each vertex of one element and each of the other.
    SKEIN_INLINE void add_pairs_of_vertices() {
        for_vertices_of<0>([&]<int one, int j>() __attribute__((always_inline)) {
            for_vertices_of<1>([&]<int other, int k>() __attribute__((always_inline)) {
                const P share_1 = corner_[one][j].share, share_2 = corner_[other][k].share, quarter(0.25);
                const Vec3<P> apart = vertex<other, k>() - vertex<one, j>();
                const P distance = norm(apart), shares = quarter * share_1 * share_2;
                const Spring s = spring(distance);
                const P push = shares * s.normal;
                const Vec3<P> force = (push / max(distance, tiny())) * apart;
                out_.energy += shares * s.energy;
                out_.normal += push;
                add_at_vertex<one, j>(-force);
                add_at_vertex<other, k>(force);
                slope_[one][j] += quarter * share_2 * s.energy;
                slope_[other][k] += quarter * share_1 * s.energy;
            });
        });
    }

    /// Forces of shares c that change: dE = slope dc for every corner.
    SKEIN_INLINE void add_changes_of_shares() {
        const P zero(0.0);
        P per_angle(0.0); // slope of E over S
        auto changes = zero > zero;
        for_vertices([&]<int i, int j>() __attribute__((always_inline)) {
            const Corner& c = corner_[i][j];
            const P over_lying = slope_[i][j] * c.per_lying,
                    over_crossing = slope_[i][j] * c.share_of_crossing * per_sine_;
            per_angle += over_crossing - over_lying * c.lying * inverse_sine_;
            changes =
                changes | (over_lying < zero) | (over_lying > zero) | (over_crossing < zero) | (over_crossing > zero);
        });
        if (!any(changes)) return;
        out_.turns = bits_of(changes);
        for_vertices([&]<int i, int j>() __attribute__((always_inline)) { add_change_of_lying<i, j>(); });
        add_change_of_angle(per_angle);
    }

    /// Points beyond vertices, where a straight neighbour sees the contact in the same place, theory.md (56f). Returns
    /// their distance.
    SKEIN_INLINE P go_beyond(const Vec3<P>& from_first, P distance) {
        const P zero(0.0);
        out_.apart = from_first;
        for (const int i : {0, 1}) out_.share[i] = element_[i].share;
        const auto goes_on = (abs(displacement_[0]) > zero) | (abs(displacement_[1]) > zero);
        if (!any(goes_on)) return distance;
        P there[2];
        shares_beyond(there);
        const Vec3<P> apart =
            fma(there[1], edge_[1], element_[1].node[1]) - fma(there[0], edge_[0], element_[0].node[1]);
        const P distance_there = norm(apart);
        const auto nearer = goes_on & (distance_there < distance);
        out_.apart = select(nearer, apart, from_first);
        for (const int i : {0, 1}) out_.share[i] = select(nearer, there[i], out_.share[i]);
        return select(nearer, distance_there, distance);
    }

    /// Sets the weight N/N* of the nearest points, and gives back the energy that these take of E.
    SKEIN_INLINE void set_weight(const Vec3<P>& from_first, P distance, P beyond_distance) {
        const P zero(0.0), one(1.0);
        const P near = max(one - sine_squared_ * P(1 / (blend * blend)), zero);
        out_.scale = one - near * near;
        const Spring own = spring(distance), whole = spring(beyond_distance);
        const P left = max(own.normal + out_.normal, zero);
        out_.weight = min(left / max(whole.normal, P(1e-300)), one);
        push_apart(own.normal, from_first, distance, element_[0].share, element_[1].share);
        push_apart(-(out_.weight * whole.normal), out_.apart, beyond_distance, out_.share[0], out_.share[1]);
        out_.energy += own.energy - out_.weight * whole.energy;
        out_.normal = out_.scale * (left - out_.weight * whole.normal);
        for (auto& of_element : out_.force)
            for (Vec3<P>& force : of_element) force = out_.scale * force;
    }

private:
    static constexpr int vertices[2] = {vertices_1, vertices_2}; ///< that may touch, of each element
    static P tiny() { return P(1e-150); }

    /// f.operator()<i, j>() for vertex j of element i.
    template <int i, class F> SKEIN_INLINE static void for_vertices_of(F&& f) {
        if constexpr (vertices[i] > 0) f.template operator()<i, 0>();
        if constexpr (vertices[i] > 1) f.template operator()<i, 1>();
    }
    template <class F> SKEIN_INLINE static void for_vertices(F&& f) {
        for_vertices_of<0>(f);
        for_vertices_of<1>(f);
    }
    /// Selects `start` for a vertex at the start, `end` for one at the end.
    template <int i, int j, class T> SKEIN_INLINE T at_side(const T& start, const T& end) const {
        if constexpr (vertices[i] == 1) return select(element_[i].at_end, end, start);
        else return j ? end : start;
    }
    template <int i, int j> SKEIN_INLINE Vec3<P> vertex() const {
        return at_side<i, j>(element_[i].node[1], element_[i].node[2]);
    }
    template <int i, int j> SKEIN_INLINE const Vec3<P>& node_of_neighbour() const {
        return element_[i].node[vertices[i] == 1 ? 0 : 3 * j];
    }
    template <int i, int j> SKEIN_INLINE void add_at_neighbour(const Vec3<P>& force) {
        out_.force[i][vertices[i] == 1 ? 0 : 3 * j] += force;
    }
    template <int i, int j> SKEIN_INLINE void add_at_vertex(const Vec3<P>& force) { add_at_node<i, j>(force, 1, 2); }
    template <int i, int j> SKEIN_INLINE void add_opposite(const Vec3<P>& force) { add_at_node<i, j>(force, 2, 1); }
    /// Adds a force to one node of a vertex at the start, to the other of a vertex at the end.
    template <int i, int j> SKEIN_INLINE void add_at_node(const Vec3<P>& force, int of_start, int of_end) {
        if constexpr (vertices[i] == 1) {
            const Vec3<P> none{};
            out_.force[i][of_start] += at_side<i, j>(force, none);
            out_.force[i][of_end] += at_side<i, j>(none, force);
        } else {
            out_.force[i][j ? of_end : of_start] += force;
        }
    }

    struct Spring {
        P normal, energy; ///< N, J
    };
    SKEIN_INLINE Spring spring(P distance) const {
        const P zero(0.0), one(1.0);
        const P depth = max(radii_ - distance, zero), root = hertz_ ? sqrt(depth) : one,
                normal = stiffness_ * root * depth;
        return {normal, P(hertz_ ? 0.4 : 0.5) * normal * depth};
    }

    /// A vertex and the other element.
    struct Corner {
        Vec3<P> apart, inwards, outwards, bend; ///< to the foot; tangents of element and neighbour; theirs apart
        P foot, on_line;                        ///< share of the other; its 1/length^2 where the foot is not at an end
        P share, share_of_crossing, per_lying;  ///< c; c over p (2 - p); dc/dQ
        P lying, longer, curved;                ///< Q; 1/l'; 2/(l + l')
        P here;                                 ///< 1 where the element's nearest point is at this vertex
    };
    template <int i, int j> SKEIN_INLINE void describe(Corner& c) const {
        const P zero(0.0), one(1.0);
        const ElementAtVertices<W>&e = element_[i], &o = element_[1 - i];
        const Vec3<P> at = vertex<i, j>(), from_vertex = node_of_neighbour<i, j>() - at, from = at - o.node[1];
        const P next = max(norm(from_vertex), tiny()), both_lengths = length_[i] + next,
                inverse = one / (next * both_lengths); // one division for two
        c.longer = both_lengths * inverse;
        c.curved = P(2.0) * (next * inverse);
        c.inwards = at_side<i, j>(-along_[i], along_[i]);
        c.outwards = c.longer * from_vertex;
        c.bend = c.outwards - c.inwards;
        const P free = dot(from, edge_[1 - i]) * inverse_squared_[1 - i];
        c.foot = clamp01(free);
        c.on_line = select((free > zero) & (free < one), inverse_squared_[1 - i], zero);
        c.apart = fma(c.foot, edge_[1 - i], -from);
        c.lying = c.curved * dot(c.bend, c.apart);
        const P x = clamp01((c.lying * inverse_sine_ - P(least_lying)) * P(1 / (most_lying - least_lying))),
                rest = one - x * x * (P(3.0) - (x + x)), joined = vertices[i] == 1 ? one : e.joined[j];
        c.share_of_crossing = joined * rest;
        c.share = c.share_of_crossing * crossing_;
        c.per_lying = -(P(6 / (most_lying - least_lying)) * joined * crossing_ * x * (one - x)) * inverse_sine_;
        c.here = at_side<i, j>(select(e.share <= zero, joined, zero), select(e.share >= one, joined, zero));
    }

    /// dE = slope dc/dQ dQ,  Q = curved bend.apart
    template <int i, int j> SKEIN_INLINE void add_change_of_lying() {
        const P half(0.5), one(1.0);
        const Corner& c = corner_[i][j];
        constexpr int o = 1 - i;
        const P weight = slope_[i][j] * c.per_lying;
        const P bent = dot(c.bend, c.apart), by_length = half * c.curved * c.curved * bent;
        const Vec3<P> of_next = (c.curved * c.longer) * (c.apart - dot(c.apart, c.outwards) * c.outwards) -
                                by_length * c.outwards,
                      of_inner = (c.curved * inverse_length_[i]) * (c.apart - dot(c.apart, c.inwards) * c.inwards) +
                                 by_length * c.inwards;
        const P along = dot(c.bend, edge_[o]) * c.on_line;
        const Vec3<P> of_foot = c.curved * (c.bend - along * edge_[o]), of_edge = (c.curved * along) * c.apart;
        add_at_neighbour<i, j>(-(weight * of_next));
        add_opposite<i, j>(-(weight * of_inner));
        add_at_vertex<i, j>(weight * (of_next + of_inner + of_foot));
        out_.force[o][1] -= weight * ((one - c.foot) * of_foot + of_edge);
        out_.force[o][2] -= weight * (c.foot * of_foot - of_edge);
    }

    /// dE = per_angle dS,  S = 1 - (e1.e2)^2/(e1^2 e2^2)
    SKEIN_INLINE void add_change_of_angle(P per_angle) {
        const P product = dot(edge_[0], edge_[1]),
                both_squared = P(2.0) * (product * inverse_squared_[0]) * inverse_squared_[1] * per_angle;
        for (const int i : {0, 1}) {
            const Vec3<P> turn = both_squared * (edge_[1 - i] - (product * inverse_squared_[i]) * edge_[i]);
            out_.force[i][2] += turn;
            out_.force[i][1] -= turn;
        }
    }

    /// Shares of the nearest points on the tangents beyond vertices, as far as bent rods stay beside these.
    SKEIN_INLINE void shares_beyond(P (&there)[2]) const {
        const P zero(0.0), one(1.0);
        const P cosine = dot(along_[0], along_[1]), inverse = one / max(sine_squared_, P(shallow * shallow)),
                both_go = goes_[0] * goes_[1], per_straight = one / (P(straight) * radii_);
        P bends(one); // length of the tangents over that of bent rods beside them, to the fourth power
        for (const int i : {0, 1}) {
            there[i] = goes_[i] * select(both_go > zero, (displacement_[i] + cosine * displacement_[1 - i]) * inverse,
                                         displacement_[i]);
            P curvature(0.0); // squared curvature of the rod beyond its vertex, 1/m^2
            for (int j = 0; j < vertices[i]; ++j) {
                const Corner& c = corner_[i][j];
                curvature += c.here * (c.curved * c.curved) * dot(c.bend, c.bend);
            }
            const P bent = there[i] * there[i] * per_straight;
            bends = max(bends, bent * bent * curvature);
        }
        const P part = one / sqrt(sqrt(bends));
        for (const int i : {0, 1}) {
            const P &share = element_[i].share, s = share + part * there[i] * inverse_length_[i];
            there[i] = select(share >= one, max(s, one), select(share <= zero, min(s, zero), clamp01(s)));
        }
    }

    SKEIN_INLINE void push_apart(const P& force, const Vec3<P>& apart, const P& distance, const P& s, const P& t) {
        const P one(1.0);
        const Vec3<P> on_first = (force / max(distance, tiny())) * apart;
        out_.force[0][1] -= (one - s) * on_first;
        out_.force[0][2] -= s * on_first;
        out_.force[1][1] += (one - t) * on_first;
        out_.force[1][2] += t * on_first;
    }

    VertexTerms<P>& out_;
    Elements element_;
    const bool hertz_;
    const P stiffness_, radii_;
    Vec3<P> edge_[2], along_[2]; ///< m; unit vectors
    P squared_[2], inverse_squared_[2], length_[2], inverse_length_[2];
    P sine_squared_, inverse_sine_, crossing_, per_sine_; ///< S, 1/S, p (2 - p), its derivative by S
    Corner corner_[2][2];
    P slope_[2][2];     ///< dE/dc of each corner, J
    P displacement_[2]; ///< way of the neighbour towards the other element, along the edge, m
    P goes_[2];         ///< 1 where the nearest point may go on along the edge
};

} // namespace detail

/// `from_first`: from the nearest point of the first element to that of the second. vertices_1, vertices_2: of each
/// element that may touch, 0, 1 or 2.
template <int W, int vertices_1, int vertices_2>
SKEIN_INLINE VertexTerms<Pack<W>> vertex_terms(ContactNormal kind, Pack<W> stiffness, Pack<W> radii,
                                               const Vec3<Pack<W>>& from_first, Pack<W> sine_squared_of_both,
                                               const ElementAtVertices<W> (&element)[2]) {
    VertexTerms<Pack<W>> out;
    detail::VertexStages<W, vertices_1, vertices_2> stages(kind, stiffness, radii, sine_squared_of_both, element, out);
    const Pack<W> distance = norm(from_first);
    stages.add_vertices();
    stages.add_pairs_of_vertices();
    stages.add_changes_of_shares();
    const Pack<W> beyond_distance = stages.go_beyond(from_first, distance);
    stages.set_weight(from_first, distance, beyond_distance);
    return out;
}

} // namespace skein
