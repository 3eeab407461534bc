// Largest stable step at present strains: rod/time_limits.hpp with the present stiffness. theory.md (51)
//   axial               A' M/l,  A' = dn_3/de + 3 sum q/E^5 over the cells on both sides
//   about d1, d2        (a + d + sqrt((a - d)^2 + 4 b^2))/2,  a = s M/l,  d = l (s e - n_3) e/J + beta,
//                       b = (s e - n_3) sqrt(M/J)
//   twist               beta_3
//   beta                sum over cells of (B g/(E^3 D) + |tau|/2)(1/J + 1/J_nb), g = ((phi/2)/sin(phi/2))^2, and over
//                       walls of B/(e^3 l/2)/J
// The measured true limit is 1.00 times this one where rods are stretched or compressed, 0.93 to 1.12 times where they
// are crumpled as well. Cost: 250 flop per element, once in 64 steps: 0.2 ns per element-step of 12.
#pragma once

#include "core/rotation.hpp"
#include "mechanics/elastic.hpp"

#include <cmath>

namespace skein {

/// Eigenvalues of one element, 1/s^2; the order is that of limiting_modes.
template <class P> struct PresentEigenvalues { P axial, about_d1, about_d2, twist; };

namespace detail {

template <class P> struct PresentCell {
    Vec3<P> spring; ///< rotational stiffness, N m
    P tension;      ///< force on both neighbours, N
    P stiffness;    ///< 3 q/E^5, or the expression of the law, N
};

template <class Law, class Map, int W>
SKEIN_INLINE PresentCell<Pack<W>> present_cell(const RodTile<W>& rod, int k, int next, Pack<W> e, Pack<W> e_next) {
    using P = Pack<W>;
    const auto& v = Map::cell(rod, k);
    const Quaternion<P>&q = rod.slot[k].director, &q_next = neighbour_frame<Map>(rod, k, next);
    const P inv_dilatation = P(1.0) / fma(P(v.share_before), e, P(v.share_after) * e_next);
    const Vec3<P> phi = relative_rotation(q_next, q),
                  strain = fma(P(v.inv_length), phi, -broadcast<W>(v.rest_curvature));
    const Vec3<P> moment = scale(broadcast<W>(v.stiffness), strain);
    const auto& e0 = Map::element(rod, k).rest_stretch;
    const auto factor = Law::bending_factor(inv_dilatation, e0);
    // 4 sin^2(phi/2); the addition to both terms removes round-off at small angles.
    const P half_cosine = dot(q, q_next), chord = P(4.0) * fnma(half_cosine, half_cosine, P(1.0));
    const P bow = (dot(phi, phi) + P(1e-10)) / (chord + P(1e-10));
    const P half_moment = P(0.5) * factored_norm(factor, moment);
    PresentCell<P> cell{(factor * bow * P(v.inv_length)) * broadcast<W>(v.stiffness) +
                            Vec3<P>{half_moment, half_moment, half_moment},
                        P(0.0), P(0.0)};
    if constexpr (Law::bending_pulls) {
        cell.tension = Law::bending_tension(strain, moment, factor, inv_dilatation, e0);
        cell.stiffness = Law::bending_stiffness(strain, moment, factor, inv_dilatation, e0);
    }
    return cell;
}

template <int W> PresentCell<Pack<W>> inner_only(Mask<W> inner, const PresentCell<Pack<W>>& cell) {
    const Pack<W> none(0.0);
    return {select(inner, cell.spring, Vec3<Pack<W>>{none, none, none}), select(inner, cell.tension, none),
            select(inner, cell.stiffness, none)};
}
template <int W> PresentCell<Pack<W>> from_lane_before(const PresentCell<Pack<W>>& cell) {
    return {skein::from_lane_before(cell.spring), skein::from_lane_before(cell.tension),
            skein::from_lane_before(cell.stiffness)};
}

/// Calls f(present, cell) for the half cells that hold element k; `present` is 1 in lanes that have one.
template <class Map, int W, class F> void with_walls_at(const RodTile<W>& rod, const Ends& ends, int k, F&& f) {
    const Pack<W> none(0.0), one(1.0);
    if constexpr (Map::along) {
        const Strands<W>& s = *rod.strands;
        if (k == 0 && s.start_walls) f(select(s.start_wall, one, none), s.start_cell);
        const Mask<W> at_end = s.cell[k].present & !s.cell[k].inner;
        if (any(at_end)) f(select(at_end, one, none), s.cell[k]);
    } else {
        if (k == 0 && ends.start_wall) f(one, rod.group->start_wall);
        if (k == rod.n - 1 && ends.end_wall) f(one, rod.group->end_wall);
    }
}

/// Cell where a ring closes, or where a lane's rod goes on in the next.
template <class Law, class Map, int W> PresentCell<Pack<W>> seam_cell(const RodTile<W>& rod, const Ends& ends) {
    const int n = rod.n;
    const auto e = [&](int k) { return element_strain<Map>(rod, k).z; };
    if constexpr (Map::along)
        return inner_only(rod.strands->cell[n - 1].inner,
                          present_cell<Law, Map>(rod, n - 1, n, e(n - 1), from_lane_after(e(0))));
    else return ends.closed ? present_cell<Law, Map>(rod, n - 1, 0, e(n - 1), e(0)) : PresentCell<Pack<W>>{};
}

/// Cell between elements k and k + 1; without stiffness where the lane has none.
template <class Law, class Map, int W>
SKEIN_INLINE PresentCell<Pack<W>> cell_after(const RodTile<W>& rod, int k, Pack<W> e, Pack<W> e_next) {
    const PresentCell<Pack<W>> cell = present_cell<Law, Map>(rod, k, k + 1, e, e_next);
    if constexpr (Map::along) return inner_only(rod.strands->cell[k].inner, cell);
    else return cell;
}

/// Calls f(k, eigenvalues) for each element.
template <class Law, class Map, int W, class F> void present_eigenvalues(const RodTile<W>& rod, F&& f) {
    using P = Pack<W>;
    const RodGroup& group = rod.group_of(0); // strands are of one family and have one law
    const Ends ends = ends_of(group);
    // Shear force and inertia of the published law go by 1/e, and bending does not pull.
    const bool published = group.law() == skein::Law::elastica;
    const int n = rod.n;
    Vec3<P> nu = element_strain<Map>(rod, 0);
    const PresentCell<P> seam = seam_cell<Law, Map>(rod, ends);
    PresentCell<P> before = seam;
    auto mobility_before = Map::element(rod, n - 1).inv_inertia, mobility = Map::element(rod, 0).inv_inertia,
         mobility_around = mobility;
    if constexpr (Map::along) {
        before = inner_only(!rod.strands->first, from_lane_before(seam));
        mobility_before = from_lane_before(mobility_before);
        mobility_around = from_lane_after(mobility);
    }
    for (int k = 0; k < n; ++k) {
        const bool last = k == n - 1;
        const Vec3<P> nu_next = last ? nu : element_strain<Map>(rod, k + 1);
        const PresentCell<P> after = last ? seam : cell_after<Law, Map>(rod, k, nu.z, nu_next.z);
        const auto& c = Map::element(rod, k);
        const auto mobility_after = last ? mobility_around : Map::element(rod, k + 1).inv_inertia;
        Vec3<P> beta = scale(before.spring, broadcast<W>(mobility + mobility_before)) +
                       scale(after.spring, broadcast<W>(mobility + mobility_after));
        with_walls_at<Map>(rod, ends, k, [&](const P& present, const auto& wall) {
            beta += (Law::bending_factor(P(1.0) / nu.z, c.rest_stretch) * (present * P(wall.inv_length))) *
                    broadcast<W>(scale(wall.stiffness, mobility));
        });

        P tension = Law::stress(c, nu).z, stretching = Law::stretch_stiffness(c, nu.z), looser(1.0), softer(1.0);
        if (published) {
            looser = nu.z;
            softer = P(1.0) / nu.z;
        } else {
            tension += before.tension + after.tension;
            stretching += before.stiffness + after.stiffness;
        }
        const auto m = 4 / (Map::nodal_density(rod) * c.volume);
        const auto shear_rotation = [&](auto shear, auto inverse_inertia, P springs) {
            const P s = softer * P(shear), j = looser * P(inverse_inertia), net = s * nu.z - tension;
            const P a = P(m * c.inv_rest_length) * s, d = P(c.rest_length) * net * nu.z * j + looser * springs;
            return P(0.5) * (a + d + sqrt((a - d) * (a - d) + P(4 * m) * net * net * j));
        };
        const P about_d1 = shear_rotation(c.stiffness.y, mobility.x, beta.x);
        bool round = false; // strands may differ
        if constexpr (!Map::along)
            round = c.inertia.x == c.inertia.y && c.stiffness.x == c.stiffness.y && c.bending.x == c.bending.y;
        f(k,
          PresentEigenvalues<P>{P(m * c.inv_rest_length) * stretching, about_d1,
                                round ? about_d1 : shear_rotation(c.stiffness.x, mobility.y, beta.y), looser * beta.z});
        before = after;
        nu = nu_next;
        mobility_before = mobility;
        mobility = mobility_after;
    }
}

} // namespace detail

/// Calls f(k, eigenvalues) for each element of a rod; bodies have none.
template <int W, class F> void present_eigenvalues(const RodTile<W>& rod, F&& f) {
    if (!rod.group_of(0).strained()) return;
    with_mapping(rod, [&]<class Map> {
        with_energy_law(rod.group_of(0).law(), [&]<class L>(L) { detail::present_eigenvalues<L, Map>(rod, f); });
    });
}

/// Largest eigenvalue of each lane, 1/s^2.
template <int W> Pack<W> largest_eigenvalue(const RodTile<W>& rod) {
    Pack<W> most(0.0);
    present_eigenvalues(rod, [&](int, const PresentEigenvalues<Pack<W>>& l) {
        most = max(max(most, l.axial), max(max(l.about_d1, l.about_d2), l.twist));
    });
    return most;
}

} // namespace skein
