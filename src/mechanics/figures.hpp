// Energies, momenta and extremes of the rods of a tile, side by side. theory.md (8)-(12)
//
//   node i         m v.v/2,  m v,  m x
//   element k      nu = Q dx/l0,  w.J w/2,  l0 times shear and axial energy of the law
//   cell k|k+1     phi = log(Q[k+1] Q[k]^T),  D/2 (kappa - kappa0).B(kappa - kappa0) times the law's factor; half cells
//                  at walls too
//
// The published law has no energy. Instead the integrals of its axial force, shear force and moment are summed, each
// alone. Cost: 220 flop per element.
#pragma once

#include "core/rotation.hpp"
#include "mechanics/law.hpp"
#include "mechanics/moving_ends.hpp"
#include "skein/core/index.hpp"
#include "tiles/rods.hpp"

namespace skein {

/// RodFigures of W rods.
template <int W> struct TileFigures { Pack<W> sum[RodFigures::sums], extreme[RodFigures::extremes]; };

namespace detail {

template <int W> SKEIN_INLINE void raise(Pack<W>& most, const Pack<W>& x) { most = max(most, x); }

template <int W> void add_nodes(TileFigures<W>& f, const RodTile<W>& rod) {
    using P = Pack<W>;
    using F = RodFigures;
    P twice(0.0), mass(0.0), fastest(0.0);
    Vec3<P> momentum{P(0.0), P(0.0), P(0.0)}, first = momentum;
    for (int i = 0; i <= rod.last; ++i) {
        const P m(nth(rod.group->node_mass, i));
        const Vec3<P>&v = rod.slot[i].velocity, &x = rod.slot[i].position;
        const P squared = dot(v, v);
        twice = fma(m, squared, twice);
        momentum = fma(m, v, momentum);
        first = fma(m, x, first);
        mass += m;
        raise(fastest, squared);
    }
    f.sum[F::translation] = P(0.5) * twice;
    f.sum[F::momentum_x] = momentum.x;
    f.sum[F::momentum_y] = momentum.y;
    f.sum[F::momentum_z] = momentum.z;
    f.sum[F::mass_x] = first.x;
    f.sum[F::mass_y] = first.y;
    f.sum[F::mass_z] = first.z;
    f.sum[F::mass] = mass;
    f.extreme[F::speed] = sqrt(fastest);
}

/// Bending (d1, d2) and twisting (d3) energy of a cell of length 1/inv_length that is turned by phi.
template <class Law, int W> SKEIN_INLINE void add_cell(TileFigures<W>& f, const Vec3<Pack<W>>& phi, double inv_length,
                                                       const Pack<W>& dilatation, const Vec3d& stiffness,
                                                       const Vec3d& rest_curvature, double rest_stretch) {
    using P = Pack<W>;
    const Vec3<P> strain = fma(P(inv_length), phi, -broadcast<W>(rest_curvature)),
                  moment = scale(broadcast<W>(stiffness), strain);
    CellFactor<P> weight = both_factors(P(0.5 / inv_length));
    if constexpr (Law::bending_pulls)
        weight = both_factors(Law::bending_factor(P(1.0) / dilatation, rest_stretch)) * weight.bending;
    f.sum[RodFigures::bend] =
        fma(weight.bending, fma(moment.x, strain.x, moment.y * strain.y), f.sum[RodFigures::bend]);
    f.sum[RodFigures::twist] = fma(weight.twist, moment.z * strain.z, f.sum[RodFigures::twist]);
}

/// Frames of the walls at an end; `of_rod` gives that of one rod.
template <int W, class F> Quaternion<Pack<W>> wall_frames(const RodTile<W>& rod, double time, F&& of_rod) {
    Quaternion<Pack<W>> frames = broadcast<W>(of_rod(*rod.group, rod.index[0], time));
    if (rod.group->walls_differ())
        for (int i = 1; i < W; ++i) set_lane(frames, i, of_rod(*rod.group, rod.index[i], time));
    return frames;
}

template <class Law, bool Published, int W> void add_elements(TileFigures<W>& f, const RodTile<W>& rod, double time) {
    using P = Pack<W>;
    using F = RodFigures;
    const RodGroup& group = *rod.group;
    const int n = rod.n, cells = static_cast<int>(group.voronoi.size());
    const Slot<W>* slot = rod.slot;
    P first_e(1.0), e_before(1.0), turned(0.0);
    const auto cell = [&](int k, int next, const P& e, const P& e_next) __attribute__((always_inline)) {
        const VoronoiConstants& v = rod.voronoi[k];
        const Vec3<P> phi = relative_rotation(slot[next].director, slot[k].director);
        raise(turned, dot(phi, phi));
        add_cell<Law>(f, phi, v.inv_length, fma(P(v.share_before), e, P(v.share_after) * e_next), v.stiffness,
                      v.rest_curvature, rod.element[k].rest_stretch);
    };
    for (int k = 0; k < n; ++k) {
        const ElementConstants& c = rod.element[k];
        const Quaternion<P>& q = slot[k].director;
        const Vec3<P> nu = P(c.inv_rest_length) * (q * (slot[k + 1].position - slot[k].position));
        P e = nu.z, half(0.5);
        if constexpr (Published) {
            e = norm(nu);
            half = half / e;
        }
        const Vec3<P>& w = slot[k].spin;
        const P sx = nu.x - P(c.rest_strain.x), sy = nu.y - P(c.rest_strain.y);
        f.sum[F::rotation] = fma(half, dot(w, scale(broadcast<W>(c.inertia), w)), f.sum[F::rotation]);
        f.sum[F::shear] =
            fma(half, P(c.rest_length * c.stiffness.x) * (sx * sx) + P(c.rest_length * c.stiffness.y) * (sy * sy),
                f.sum[F::shear]);
        f.sum[F::stretch] = fma(P(c.rest_length), Law::stretch_energy(c, e), f.sum[F::stretch]);
        raise(f.extreme[F::strain], abs(nu.z - P(c.rest_stretch)));
        raise(f.extreme[F::skew], abs(dot(q, q) - P(1.0)));
        if (k == 0) first_e = e;
        else cell(k - 1, k, e_before, e);
        e_before = e;
    }
    if (cells == n) cell(n - 1, 0, e_before, first_e); // a ring
    f.extreme[F::turn] = sqrt(turned);
    const auto wall = [&](const VoronoiConstants& v, const Quaternion<P>& after, const Quaternion<P>& before,
                          const P& e) {
        add_cell<Law>(f, relative_rotation(after, before), v.inv_length, e, v.stiffness, v.rest_curvature,
                      rod.element[0].rest_stretch);
    };
    if (group.spec().start == EndKind::clamped)
        wall(group.start_wall, slot[0].director, wall_frames(rod, time, start_wall_frame), first_e);
    if (group.spec().end == EndKind::clamped)
        wall(group.end_wall, wall_frames(rod, time, end_wall_frame), slot[n - 1].director, e_before);
}

/// Energy of an element that is not strained.
template <int W> void add_body(TileFigures<W>& f, const RodTile<W>& rod) {
    using P = Pack<W>;
    using F = RodFigures;
    const Vec3<P>& w = rod.slot[0].spin;
    const Quaternion<P>& q = rod.slot[0].director;
    f.sum[F::rotation] = P(0.5) * dot(w, scale(broadcast<W>(rod.element[0].inertia), w));
    f.extreme[F::skew] = abs(dot(q, q) - P(1.0));
}

} // namespace detail

/// Figures of a tile across at one time. `time`: time of turning walls, s.
template <int W> TileFigures<W> figures_of(const RodTile<W>& rod, double time) {
    TileFigures<W> f;
    for (Pack<W>& p : f.sum) p = Pack<W>(0.0);
    for (Pack<W>& p : f.extreme) p = Pack<W>(0.0);
    detail::add_nodes(f, rod);
    if (!rod.group->strained()) detail::add_body(f, rod);
    else if (rod.group->law() == Law::elastica) detail::add_elements<IncompressibleLaw, true>(f, rod, time);
    else with_energy_law(rod.group->law(), [&]<class L>(L) { detail::add_elements<L, false>(f, rod, time); });
    return f;
}

/// Writes the figures of the first lanes, as many as `out` has room for.
template <int W> void put_figures(const TileFigures<W>& f, std::span<RodFigures> out) {
    for (std::size_t i = 0; i < out.size(); ++i) {
        for (int s = 0; s < RodFigures::sums; ++s) out[i].sum[s] = f.sum[s][static_cast<int>(i)];
        for (int x = 0; x < RodFigures::extremes; ++x) out[i].extreme[x] = f.extreme[x][static_cast<int>(i)];
    }
}

} // namespace skein
