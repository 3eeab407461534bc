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
#include "core/closest_points.hpp"
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
        across_ = cross(edge_[0], edge_[1]);
        across_squared_ = dot(across_, across_);
        const bool points = value_of(squared_[0]) == 0 || value_of(squared_[1]) == 0; // which cross everything
        sine_squared_ = points ? T(1.0) : across_squared_ / (squared_[0] * squared_[1]);
        crossed_ = value_of(sine_squared_) > 1e-14;
        same_way_ = value_of(dot(edge_[0], edge_[1])) > 0;
        find_nearest();
    }

    double overlap() const { return radii_ - __builtin_sqrt(value_of(distance_squared_)); } ///< below 0: apart; m
    double share(int i) const { return share_[i]; } ///< place of the nearest point on element i

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
    static T clamped(const T& x) { return value_of(x) <= 0 ? T(0.0) : value_of(x) >= 1 ? T(1.0) : x; }
    static bool is_clamped(const T& x) { return value_of(x) <= 0 || value_of(x) >= 1; }

    /// theory.md (52). Within both elements the distance is that of their lines along the normal of both, r.n/|n|,
    /// which has more digits at shallow angles than that of the nearest points. There r may lead from any points of the
    /// lines.
    void find_nearest() {
        const auto at = [&](int i) { return broadcast<1>(values_of(element_[i].node[1])); };
        const auto along = [&](int i) { return broadcast<1>(values_of(edge_[i])); };
        const ClosestPoints<Pack<1>> nearest = closest_points(at(0), along(0), at(1), along(1));
        const double s = share_[0] = nearest.s[0], t = share_[1] = nearest.t[0];
        const bool within_first = s != 0 && s != 1, within_second = t != 0 && t != 1;
        if (within_first && within_second && crossed_) {
            const T apart = dot(point(1, t) - point(0, s), across_);
            distance_squared_ = apart * apart / across_squared_;
        } else {
            const bool end_of_second = within_first && !within_second;
            const Vec3<T> apart = end_of_second ? to_foot(point(1, t), 0) : to_foot(point(0, s), 1);
            distance_squared_ = dot(apart, apart);
        }
    }
    Vec3<T> point(int i, double share) const {
        return element_[i].node[1] + Vec3<T>{share * edge_[i].x, share * edge_[i].y, share * edge_[i].z};
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
        if (value_of(squared_[on]) == 0) return -from;
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

    /// E_0. Vertices have no share where elements are parallel, as p = 0.
    T energy_less_vertices() {
        const T p = value_of(sine_squared_) < shallow * shallow ? (1 / (shallow * shallow)) * sine_squared_ : T(1.0);
        crossing_ = p * (2.0 - p);
        T energy = spring(distance_squared_);
        for (const int i : {0, 1})
            for (const bool end : {false, true}) {
                Corner& corner = corner_[i][end];
                if (!crossed_ || !element_[i].joined[end]) continue;
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
    /// An end of the first element with its foot on the second, or the second's end there with its foot on the first.
    /// Parallel elements have both equally far, so that the last digit decides, as it does in a step.
    T energy_at_end(bool end) const {
        const bool end_of_second = same_way_ ? end : !end;
        const Vec3<T>&first = element_[0].node[1 + end], &second = element_[1].node[1 + end_of_second];
        const bool nearer = squared_to_foot(first, 1) <= squared_to_foot(second, 0);
        const Vec3<T> apart = nearer ? to_foot(first, 1) : to_foot(second, 0);
        return spring(dot(apart, apart));
    }
    double squared_to_foot(const Vec3<T>& point, int on) const {
        const Vec3d from = values_of(point), start = values_of(element_[on].node[1]), edge = values_of(edge_[on]);
        const double free = dot(from - start, edge) / dot(edge, edge);
        const Vec3d apart = fma(std::clamp(free, 0.0, 1.0), edge, start) - from;
        return dot(apart, apart);
    }
    /// lambda of (56e) of element i. Its slope jumps where both are equally long: there it is that of overlap_on(), to
    /// the last digit.
    T share_beside(int i) const {
        const ContactElement<T>&e = element_[i], &o = element_[1 - i];
        if (!(e.joined[0] || e.joined[1] || o.joined[0] || o.joined[1])) return T(1.0);
        const bool same = same_way_;
        const T start = dot(o.node[1] - e.node[1], edge_[i]) / squared_[i],
                end = start + dot(edge_[1 - i], edge_[i]) / squared_[i];
        const T &first = same ? start : end, &last = same ? end : start, span = last - first;
        const bool by_first = value_of(first) > 0, by_last = value_of(last) < 1,
                   at_vertex = (by_first ? o.joined[!same] : e.joined[0]) || (by_last ? o.joined[same] : e.joined[1]);
        T x = (by_last ? last : T(1.0)) - (by_first ? first : T(0.0));
        if (!(value_of(x) > 0)) return T(at_vertex ? 0.0 : 1.0);
        if (value_of(span) < 1) x = x / span;
        return at_vertex ? x : 1.0 - x * x * (1.0 - x);
    }

    NormalLaw law_;
    Elements element_;
    double radii_;                      ///< m
    Vec3<T> edge_[2], across_;          ///< e_i, e_1 x e_2
    T squared_[2], across_squared_;     ///< their squares
    T sine_squared_, distance_squared_; ///< S; squared distance of the nearest points, m^2
    double share_[2];                   ///< places of these
    bool crossed_, same_way_;           ///< S is known; both elements lead the same way
    T crossing_;                        ///< p (2 - p)
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
    double stiffness[3 * most_nodes][3 * most_nodes]; ///< -d(force)/d(place) between `nodes` nodes, N/m
};

/// False where the elements do not touch.
bool respond(NormalLaw law, const ContactElement<double> (&element)[2], ContactResponse& out);

} // namespace skein
