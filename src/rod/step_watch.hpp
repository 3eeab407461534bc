// What strains leave of the largest stable step: rod/time_limits.hpp with the stiffness of the moment.            theory.md (51)
//   axial               A' M/l,  A' = dn_3/de + 3 sum q/E^5 over the cells beside
//   about d1, d2        (a + d + sqrt((a - d)^2 + 4 b^2))/2,  a = s M/l,  d = l (s e - n_3) e/J + beta,  b = (s e - n_3) sqrt(M/J)
//   twist               beta_3
//   beta = sum over cells of (B g/(E^3 D) + |tau|/2)(1/J + 1/J_nb), g = ((phi/2)/sin(phi/2))^2, and of walls, B/(e^3 l/2)/J
// Measured true limit over it: 1.00 where rods are stretched or compressed, 0.93 to 1.12 where they are crumpled as well.
// Cost: 250 flop per element, once in 64 steps: 0.2 ns per element-step of 12.
#pragma once

#include "core/rotation.hpp"
#include "rod/elastic.hpp"

#include <cmath>

namespace skein {

/// How long the step is, for those who watch its limit.
struct StepWatch {
    static constexpr double near = 0.93; ///< share of the limit beyond which it may be passed in truth
    double dt = 0;                       ///< s; 0: nobody watches
    double stability = 1;                ///< of the scheme, over Verlet's
    bool stops = true;                   ///< a rod is unfit where the step is beyond its limit

    /// (dt over the limit)^2 of a mode with this eigenvalue, 1/s^2.
    double share_squared() const { return 0.25 * dt * dt / (stability * stability); }
};

/// Eigenvalues of one element, 1/s^2; the order is that of `present_modes`.
template <class P> struct PresentEigenvalues { P axial, about_d1, about_d2, twist; };
inline constexpr const char* present_modes[] = {"axial", "shear-rotation about d1", "shear-rotation about d2", "twist"};

namespace detail {

template <class P> struct PresentCell {
    Vec3<P> spring; ///< of rotations, N m
    P tension;      ///< on both neighbours, N
    P stiffness;    ///< 3 q/E^5, N
};

template <class Law, int W>
SKEIN_INLINE PresentCell<Pack<W>> present_cell(const RodTile<W>& rod, int k, int next, Pack<W> e, Pack<W> e_next) {
    using P = Pack<W>;
    const VoronoiConstants& v = rod.voronoi[k];
    const Quaternion<P>&q = rod.slot[k].director, &q_next = rod.slot[next].director;
    const P inv_dilatation = P(1.0) / fma(P(v.share_before), e, P(v.share_after) * e_next);
    const Vec3<P> phi = relative_rotation(q_next, q), strain = fma(P(v.inv_length), phi, -broadcast<W>(v.rest_curvature));
    const Vec3<P> moment = scale(broadcast<W>(v.stiffness), strain);
    const P factor = Law::bending_factor(inv_dilatation), work = dot(strain, moment);
    // 4 sin^2(phi/2); what is added to both takes round-off out of small angles.
    const P half_cosine = dot(q, q_next), chord = P(4.0) * fnma(half_cosine, half_cosine, P(1.0));
    const P bow = (dot(phi, phi) + P(1e-10)) / (chord + P(1e-10));
    const P half_moment = P(0.5) * factor * norm(moment);
    PresentCell<P> cell{(factor * bow * P(v.inv_length)) * broadcast<W>(v.stiffness) +
                            Vec3<P>{half_moment, half_moment, half_moment},
                        P(0.0), P(0.0)};
    if constexpr (Law::bending_pulls) {
        cell.tension = Law::bending_tension(work, factor, inv_dilatation);
        cell.stiffness = P(3.0) * work * factor * inv_dilatation * inv_dilatation;
    }
    return cell;
}

/// Calls f(k, eigenvalues) for each element.
template <class Law, int W, class F> void present_eigenvalues(const RodTile<W>& rod, F&& f) {
    using P = Pack<W>;
    const RodGroup& group = *rod.group;
    const Ends ends = ends_of(group);
    // Its shear force and its inertia go by 1/e, and bending does not pull.
    const bool published = group.law() == skein::Law::elastica;
    const int n = rod.n;
    const auto strain = [&](int k) {
        return P(rod.element[k].inv_rest_length) * (rod.slot[k].director * (rod.slot[k + 1].position - rod.slot[k].position));
    };
    Vec3<P> nu = strain(0);
    const PresentCell<P> none{};
    const PresentCell<P> first = ends.closed ? present_cell<Law>(rod, n - 1, 0, strain(n - 1).z, nu.z) : none;
    PresentCell<P> before = first;
    Vec3d mobility_before = rod.element[n - 1].inv_inertia, mobility = rod.element[0].inv_inertia;
    for (int k = 0; k < n; ++k) {
        const bool last = k == n - 1;
        const Vec3<P> nu_next = last ? nu : strain(k + 1);
        const PresentCell<P> after = !last ? present_cell<Law>(rod, k, k + 1, nu.z, nu_next.z) : ends.closed ? first : none;
        const ElementConstants& c = rod.element[k];
        const Vec3d mobility_after = rod.element[(k + 1) % n].inv_inertia;
        Vec3<P> beta = scale(before.spring, broadcast<W>(mobility + mobility_before)) +
                       scale(after.spring, broadcast<W>(mobility + mobility_after));
        const double walls = (k == 0 && ends.start_wall) + (last && ends.end_wall);
        if (walls > 0)
            beta += (P(2 * walls * c.inv_rest_length) * Law::bending_factor(P(1.0) / nu.z)) * broadcast<W>(scale(c.bending, mobility));

        P tension = Law::stress(c, nu).z, stretching = Law::stretch_stiffness(c, nu.z), looser(1.0), softer(1.0);
        if (published)
            looser = nu.z, softer = P(1.0) / nu.z;
        else
            tension += before.tension + after.tension, stretching += before.stiffness + after.stiffness;
        const double m = 4 / (group.spec().material.density * c.volume);
        const auto shear_rotation = [&](double shear, double inverse_inertia, P springs) {
            const P s = softer * P(shear), j = looser * P(inverse_inertia), net = s * nu.z - tension;
            const P a = P(m * c.inv_rest_length) * s, d = P(c.rest_length) * net * nu.z * j + looser * springs;
            return P(0.5) * (a + d + sqrt((a - d) * (a - d) + P(4 * m) * net * net * j));
        };
        const P about_d1 = shear_rotation(c.stiffness.y, mobility.x, beta.x);
        const bool round = c.inertia.x == c.inertia.y;
        f(k, PresentEigenvalues<P>{P(m * c.inv_rest_length) * stretching, about_d1,
                                   round ? about_d1 : shear_rotation(c.stiffness.x, mobility.y, beta.y), looser * beta.z});
        before = after;
        nu = nu_next;
        mobility_before = mobility;
        mobility = mobility_after;
    }
}

} // namespace detail

template <int W, class F> void present_eigenvalues(const RodTile<W>& rod, F&& f) {
    with_energy_law(rod.group->law(), [&]<class L>(L) { detail::present_eigenvalues<L>(rod, f); });
}

/// The largest of each lane.
template <int W> Pack<W> largest_eigenvalue(const RodTile<W>& rod) {
    Pack<W> most(0.0);
    present_eigenvalues(rod, [&](int, const PresentEigenvalues<Pack<W>>& l) {
        most = max(max(most, l.axial), max(max(l.about_d1, l.about_d2), l.twist));
    });
    return most;
}

} // namespace skein
