// Half cells of two or more elements that meet in a place, as one cell between them.           theory.md (73a)-(73c)
//   phi_i = log(Q_i (C_i Q_0)^T), phi_0 = 0;  s_i = phi_i - psi_i - C_i theta;  tau_i = f(E) K_i s_i
//   theta such that sum C_i^T tau_i = 0;  0 where the first is rigid
//   on i      a/2 - b,  a = phi_i x tau_i,  b = tau_i + g(phi_i) phi_i x a
//   on 0      C_i^T (b + a/2)
//   tension   as a cell's, of the law, from E = sum l_i e_i/sum l_i, on all elements
//   muscles   m_i at the end of element i: -m_i - K_i C_i theta_m is added to tau_i, theta_m alike
// psi_i: rest curvature of the half cell less that of the start; K_i = 2 B_i/l_i.
#pragma once

#include "core/rotation.hpp"
#include "joints/junction.hpp"
#include "mechanics/law.hpp"

#include <array>

namespace skein {

/// An element of a star as it is.
template <class P> struct StarElement {
    Quaternion<P> director;
    Vec3<P> edge;   ///< from node to node, m
    Vec3<P> moment; ///< moment of muscles at its end, body, outwards, N m
};
template <class P> struct StarLoad {
    Vec3<P> couple;  ///< body, N m
    Vec3<P> force{}; ///< on the first node, and the opposite on the second, lab, N
};
template <class P> using StarElements = std::array<StarElement<P>, most_members>;
template <class P> using StarLoads = std::array<StarLoad<P>, most_members>;

namespace detail {
template <class P> SKEIN_INLINE Vec3<P> times(const Mat3d& m, const Vec3<P>& v) {
    const auto row = [&](const Vec3d& r) { return fma(P(r.x), v.x, fma(P(r.y), v.y, P(r.z) * v.z)); };
    return {row(m.d1), row(m.d2), row(m.d3)};
}
template <class P> SKEIN_INLINE Vec3<P> transpose_times(const Mat3d& m, const Vec3<P>& v) {
    return {fma(P(m.d1.x), v.x, fma(P(m.d2.x), v.y, P(m.d3.x) * v.z)),
            fma(P(m.d1.y), v.x, fma(P(m.d2.y), v.y, P(m.d3.y) * v.z)),
            fma(P(m.d1.z), v.x, fma(P(m.d2.z), v.y, P(m.d3.z) * v.z))};
}
} // namespace detail

/// Loads of a star on its elements; adds to `energy` that of its half cells, J, where it is not null.
template <class L, int W> void star_loads(const Star& star, bool muscles, const StarElements<Pack<W>>& now,
                                          StarLoads<Pack<W>>& out, Pack<W>* energy = nullptr) {
    using P = Pack<W>;
    const std::size_t n = star.members.size();
    std::array<RelativeRotation<P>, most_members> turn;
    turn[0] = {{P(0.0), P(0.0), P(0.0)}, P(0.0)};
    for (std::size_t i = 1; i < n; ++i)
        turn[i] = relative_rotation_and_jacobian(now[i].director, broadcast<W>(star.members[i].rest) * now[0].director);
    const std::size_t first = star.rigid ? 1 : 0;

    Vec3<P> frame{P(0.0), P(0.0), P(0.0)}, frame_of_muscles = frame;
    P dilatation(0.0);
    std::array<Vec3<P>, most_members> along; // nu of each element
    for (std::size_t i = first; i < n; ++i) {
        const Star::Member& m = star.members[i];
        along[i] = P(1 / m.length) * (now[i].director * now[i].edge);
        dilatation = fma(P(m.share), along[i].z, dilatation);
        if (star.rigid) continue;
        frame += detail::times(m.to_frame, turn[i].log - broadcast<W>(m.rest_turn));
        if (muscles) frame_of_muscles -= detail::times(m.to_frame, scale(broadcast<W>(m.compliance), now[i].moment));
    }
    const double rest_stretch = star.members[first].rest_stretch;
    const P inv_dilatation = L::bending_pulls ? P(1.0) / dilatation : P(1.0);
    const auto factor = L::bending_factor(inv_dilatation, rest_stretch);
    P tension(0.0);
    out[0].couple = {P(0.0), P(0.0), P(0.0)};
    for (std::size_t i = first; i < n; ++i) {
        const Star::Member& m = star.members[i];
        const Vec3<P> strain = turn[i].log - broadcast<W>(m.rest_turn) - detail::times(m.turn, frame),
                      moment = scale(broadcast<W>(m.stiffness), strain);
        Vec3<P> tau = moment;
        if constexpr (L::bending_pulls) {
            const Vec3<P> per_length = P(star.inv_cell) * strain;
            if (star.along_axes) {
                tau = factor * moment;
                tension = tension + L::bending_tension(per_length, moment, factor, inv_dilatation, rest_stretch);
            } else { // one factor for all axes, that of bending
                tau = both_factors(factor).bending * moment;
                const P product = dot(per_length, moment), none(0.0);
                tension = tension + L::bending_tension(Vec3<P>{product, none, none}, Vec3<P>{P(1.0), none, none},
                                                       factor, inv_dilatation, rest_stretch);
            }
        }
        if (energy) *energy = *energy + P(0.5) * dot(strain, tau);
        if (i == 0) continue; // its share of the balance is the others'
        if (muscles) tau += -now[i].moment - scale(broadcast<W>(m.stiffness), detail::times(m.turn, frame_of_muscles));
        const Vec3<P>&phi = turn[i].log, a = cross(phi, tau), half = P(0.5) * a,
              straight = fma(turn[i].jacobian, cross(phi, a), tau);
        out[i].couple = half - straight;
        out[0].couple += detail::transpose_times(m.turn, straight + half);
    }
    if constexpr (L::bending_pulls)
        for (std::size_t i = first; i < n; ++i) {
            const P length(star.members[i].length);
            out[i].force = tension * third_director(now[i].director);
            out[i].couple += length * (tension * Vec3<P>{along[i].y, -along[i].x, P(0.0)});
        }
}

} // namespace skein
