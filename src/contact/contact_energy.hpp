// Energy of the normal springs of two elements as a function of their nodes, over any type of numbers: with those of
// core/second_order.hpp it gives forces and stiffness.                           theory.md (52), (54), (56b)-(56e)
//   E   = (1 - a) E_0 + a L (E_1 + E_2)/2,  a = (1 - S/b^2)^2 of near-parallel elements, else 0
//   E_0 = phi(e, f) - sum_v c_v phi(v, f)/2 - sum_w c_w phi(e, w)/2 + sum_vw c_v c_w phi(v, w)/4
//   phi   energy of the normal spring;  v, w: vertices of e and f, as balls;  c: shares (56d)
//   E_k   phi at an end of the overlap;  L: mean of both shares that lie beside the other (56e)
// vertex_terms.hpp, near_parallel.cpp and overlap.hpp write out the same gradient for the forces of a step.
#pragma once

#include "contact/contact_law.hpp"
#include "contact/vertices.hpp"
#include "core/second_order.hpp"

#include <algorithm>

namespace skein {

/// An element of a pair, with nodes of its neighbours.
template <class T> struct ContactElement {
    Vec3<T> node[4]; ///< node before, start, end, node after; the outer ones any where there is no neighbour
    bool joined[2];  ///< to a neighbour at the start, at the end
    double radius;   ///< m
};

struct NormalLaw {
    ContactNormal kind;
    double stiffness; ///< N/m or N/m^1.5
};

template <class T> class PairEnergy {
public:
    using Elements = const ContactElement<T> (&)[2];

    PairEnergy(NormalLaw law, Elements element)
        : law_(law), element_(element), radii_(element[0].radius + element[1].radius) {
        for (const int i : {0, 1}) {
            edge_[i] = element[i].node[2] - element[i].node[1];
            squared_[i] = dot(edge_[i], edge_[i]);
        }
        along_ = dot(edge_[0], edge_[1]);
        const Vec3<T> across = cross(edge_[0], edge_[1]);
        across_squared_ = dot(across, across);
        sine_squared_ = across_squared_ / (squared_[0] * squared_[1]);
        find_nearest();
    }

    double overlap() const { return radii_ - __builtin_sqrt(value_of(distance_squared_)); } ///< below 0: apart; m
    double share(int i) const { return value_of(share_[i]); } ///< place of the nearest point on element i

    T energy() {
        if (!(overlap() > 0)) return T(0.0);
        const T nearest = energy_less_vertices();
        return value_of(sine_squared_) < blend * blend ? near_parallel(nearest) : nearest;
    }
    /// True where the energy depends on the neighbour's node at this vertex; after energy().
    bool bends(int i, bool end) const { return corner_[i][end].bends; }

private:
    /// A vertex and the other element.
    struct Corner {
        bool touches = false, bends = false;
        T energy, share; ///< phi, c
    };
    static constexpr double parallel = 1e-14; ///< S below which no point is nearest

    static T clamped(const T& x) { return value_of(x) <= 0 ? T(0.0) : value_of(x) >= 1 ? T(1.0) : x; }
    static bool is_clamped(const T& x) { return value_of(x) <= 0 || value_of(x) >= 1; }

    /// theory.md (52), by the steps of core/closest_points.hpp; the last one changes s only where t is at an end.
    void find_nearest() {
        const Vec3<T> from = element_[0].node[1] - element_[1].node[1];
        const T c = dot(edge_[0], from), f = dot(edge_[1], from);
        T &s = share_[0], &t = share_[1];
        const bool crossed = value_of(sine_squared_) > parallel;
        if (crossed) {
            s = clamped((along_ * f - c * squared_[1]) / across_squared_);
        } else {
            const T per_squared = inverse(squared_[0]);
            s = 0.5 * (clamped(-(c * per_squared)) + clamped((along_ - c) * per_squared));
        }
        t = clamped((along_ * s + f) / squared_[1]);
        if (crossed && is_clamped(t)) s = clamped((along_ * t - c) / squared_[0]);
        const Vec3<T> apart = t * edge_[1] - from - s * edge_[0];
        distance_squared_ = dot(apart, apart);
    }

    bool touch(const T& squared) const { return value_of(squared) < radii_ * radii_; }
    /// Energy of the normal spring at a squared distance.
    T spring(const T& squared) const {
        if (!touch(squared)) return T(0.0);
        const T depth = radii_ - sqrt(squared), work = depth * depth;
        return law_.kind == ContactNormal::hertz ? 0.4 * law_.stiffness * (work * sqrt(depth))
                                                 : 0.5 * law_.stiffness * work;
    }

    /// Vector from a point to the nearest one of an element.
    Vec3<T> to_foot(const Vec3<T>& point, int on) const {
        const Vec3<T> from = point - element_[on].node[1];
        const T free = dot(from, edge_[on]) / squared_[on];
        if (value_of(free) <= 0) return -from;
        if (value_of(free) >= 1) return element_[on].node[2] - point;
        return free * edge_[on] - from;
    }

    /// c of (56d) at a vertex whose foot is at `apart` from it.
    void set_share(int i, bool end, const Vec3<T>& apart, Corner& corner) const {
        const Vec3<T>(&node)[4] = element_[i].node;
        const Vec3<T> beyond = end ? node[3] - node[2] : node[0] - node[1];
        const T length = sqrt(squared_[i]), next = norm(beyond);
        const Vec3<T> inwards = inverse(length) * (end ? edge_[i] : -edge_[i]), outwards = inverse(next) * beyond;
        const T lying = 2.0 * (dot(outwards - inwards, apart) / (length + next)),
                free = (1 / (most_lying - least_lying)) * (-least_lying + lying / sine_squared_), x = clamped(free);
        corner.bends = !is_clamped(free);
        corner.share = (1.0 - x * x * (3.0 - 2.0 * x)) * crossing_;
    }

    T energy_less_vertices() {
        const T p = value_of(sine_squared_) < shallow * shallow ? (1 / (shallow * shallow)) * sine_squared_ : T(1.0);
        crossing_ = p * (2.0 - p);
        T energy = spring(distance_squared_);
        for (const int i : {0, 1})
            for (const bool end : {false, true}) {
                Corner& corner = corner_[i][end];
                if (!element_[i].joined[end]) continue;
                const Vec3<T> apart = to_foot(element_[i].node[1 + end], 1 - i);
                const T squared = dot(apart, apart);
                if (!(corner.touches = touch(squared))) continue;
                corner.energy = spring(squared);
                set_share(i, end, apart, corner);
                energy = energy - 0.5 * (corner.share * corner.energy);
            }
        for (const bool end : {false, true})
            for (const bool other : {false, true}) {
                const Corner &v = corner_[0][end], &w = corner_[1][other];
                if (!v.touches || !w.touches) continue;
                const Vec3<T> apart = element_[1].node[1 + other] - element_[0].node[1 + end];
                const T squared = dot(apart, apart);
                if (touch(squared)) energy = energy + 0.25 * (v.share * w.share * spring(squared));
            }
        return energy;
    }

    /// (56b), (56e)
    T near_parallel(const T& nearest) const {
        const T near = 1.0 - (1 / (blend * blend)) * sine_squared_, a = near * near,
                ends = 0.5 * (energy_at_end(false) + energy_at_end(true)),
                beside = 0.5 * (share_beside(0) + share_beside(1));
        return nearest + a * (beside * ends - nearest);
    }
    bool same_way() const { return value_of(along_) > 0; }
    /// An end of the first element with its foot on the second, or the second's end there with its foot on the first.
    T energy_at_end(bool end) const {
        const bool end_of_second = same_way() ? end : !end;
        const Vec3<T> from_first = to_foot(element_[0].node[1 + end], 1),
                      from_second = to_foot(element_[1].node[1 + end_of_second], 0);
        const T first = dot(from_first, from_first), second = dot(from_second, from_second);
        return spring(value_of(first) <= value_of(second) ? first : second);
    }
    /// lambda of (56e) of element i, by the rules of overlap_on().
    T share_beside(int i) const {
        const ContactElement<T>&e = element_[i], &o = element_[1 - i];
        if (!(e.joined[0] || e.joined[1] || o.joined[0] || o.joined[1])) return T(1.0);
        const bool same = same_way();
        const auto foot = [&](bool end) -> T { return dot(o.node[1 + end] - e.node[1], edge_[i]) / squared_[i]; };
        const T first = foot(!same), last = foot(same), span = last - first;
        const bool by_first = value_of(first) > 0, by_last = value_of(last) < 1,
                   at_vertex = (by_first ? o.joined[!same] : e.joined[0]) || (by_last ? o.joined[same] : e.joined[1]);
        T x = (by_last ? last : T(1.0)) - (by_first ? first : T(0.0));
        if (!(value_of(x) > 0)) return T(at_vertex ? 0.0 : 1.0);
        if (value_of(span) < 1) x = x / span;
        return at_vertex ? x : 1.0 - x * x * (1.0 - x);
    }

    NormalLaw law_;
    Elements element_;
    double radii_;                               ///< m
    Vec3<T> edge_[2];                            ///< m
    T squared_[2], along_, across_squared_;      ///< of the edges: e_i^2, e_1.e_2, |e_1 x e_2|^2
    T sine_squared_, share_[2], distance_squared_; ///< S; of the nearest points
    T crossing_;                                 ///< p (2 - p)
    Corner corner_[2][2];
};

/// A pair in contact: energy, forces on its nodes, and their slopes.
struct ContactResponse {
    static constexpr int most_nodes = 8;
    struct Node {
        int element, place; ///< 0 or 1; of ContactElement::node
        Vec3d force;        ///< N
    };
    double energy, overlap; ///< J; m
    double share[2];        ///< places of the nearest points
    int nodes;              ///< on which the energy depends
    Node node[most_nodes];
    double stiffness[3 * most_nodes][3 * most_nodes]; ///< -d(force)/d(place), N/m; unset where none is asked for
};

/// False where the elements do not touch.
bool respond(NormalLaw law, const ContactElement<double> (&element)[2], ContactResponse& out);

} // namespace skein
