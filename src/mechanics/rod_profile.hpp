// Strains of the rods of a tile, node by node, for outputs. theory.md (5)-(10)
//   energy  half of the energy of the elements on both sides of a node, and that of the cell around it, over the rest
//           length of both halves; its sum over nodes times that length is the rod's elastic energy
// Cost: 250 flop per node.
#pragma once

#include "core/rotation.hpp"
#include "mechanics/figures.hpp"
#include "mechanics/law.hpp"
#include "skein/core/index.hpp"
#include "tiles/rods.hpp"

#include <algorithm>
#include <type_traits>

namespace skein {

namespace detail {

/// Adds a cell that is turned by phi. `weight` is D_w/D; the curvature is phi/D_w.
template <class Law, int W> SKEIN_INLINE void add_cell(NodeProfileOf<Pack<W>>& at, const Vec3<Pack<W>>& phi,
                                                       const VoronoiConstants& v, double weight,
                                                       const Pack<W>& dilatation, double rest_stretch) {
    using P = Pack<W>;
    const Vec3<P> curvature = P(v.inv_length / weight) * phi,
                  strain = P(v.inv_length) * phi - broadcast<W>(v.rest_curvature);
    const Vec3<P> moment = scale(broadcast<W>(v.stiffness), strain);
    at.curvature = sqrt(fma(curvature.x, curvature.x, curvature.y * curvature.y));
    P half_length(0.5 / v.inv_length), work = dot(strain, moment);
    if constexpr (Law::bending_pulls) {
        const auto factor = Law::bending_factor(P(1.0) / dilatation, rest_stretch);
        if constexpr (std::is_same_v<decltype(factor), const P>) half_length *= factor;
        else work = dot(strain, factor * moment);
    }
    at.energy = fma(half_length, work, at.energy);
}

/// `Published`: the law without an energy, for which the integrals of the observables are taken.
template <class Law, bool Published, int W>
void rod_profile(const RodTile<W>& rod, double time, NodeProfileOf<Pack<W>>* out) {
    using P = Pack<W>;
    const RodGroup& group = *rod.group;
    const Slot<W>* slot = rod.slot;
    const int n = rod.n;
    P first_e(1.0), e_before(1.0);
    const auto cell = [&](int k, int next, const P& e, const P& e_next) __attribute__((always_inline)) {
        const VoronoiConstants& v = rod.voronoi[k];
        add_cell<Law>(out[k + 1], relative_rotation(slot[next].director, slot[k].director), v,
                      cell_weight(group, to_index(k) + 1), fma(P(v.share_before), e, P(v.share_after) * e_next),
                      rod.element[k].rest_stretch);
    };
    for (int k = 0; k < n; ++k) {
        const ElementConstants& c = rod.element[k];
        const Vec3<P> nu = P(c.inv_rest_length) * (slot[k].director * (slot[k + 1].position - slot[k].position));
        P e = nu.z, half(0.5);
        if constexpr (Published) {
            e = norm(nu);
            half = half / e;
        }
        const P sx = nu.x - P(c.rest_strain.x), sy = nu.y - P(c.rest_strain.y);
        const P shear = half * fma(P(c.stiffness.x) * sx, sx, P(c.stiffness.y) * sy * sy);
        const P strain = P(0.5) * (e - P(c.rest_stretch)),
                energy = P(0.5 * c.rest_length) * (shear + Law::stretch_energy(c, e));
        out[k].strain += strain;
        out[k].energy += energy;
        out[k + 1].strain += strain;
        out[k + 1].energy += energy;
        if (k == 0) first_e = e;
        else cell(k - 1, k, e_before, e);
        e_before = e;
    }
    if (group.closed()) cell(n - 1, 0, e_before, first_e);
    const auto wall = [&](int node, const VoronoiConstants& v, const Quaternion<P>& after, const Quaternion<P>& before,
                          const P& e) {
        add_cell<Law>(out[node], relative_rotation(after, before), v, cell_weight(group, to_index(node)), e,
                      rod.element[0].rest_stretch);
    };
    if (group.spec().start == EndKind::clamped)
        wall(0, group.start_wall, slot[0].director, wall_frames(rod, time, start_wall_frame), first_e);
    if (group.spec().end == EndKind::clamped)
        wall(n, group.end_wall, wall_frames(rod, time, end_wall_frame), slot[n - 1].director, e_before);

    const auto half_length = [&](int k) { return 0.5 * rod.element[k].rest_length; };
    for (int i = 1; i < n; ++i) out[i].energy *= P(1 / (half_length(i - 1) + half_length(i)));
    if (group.closed()) {
        const P length_inverse(1 / (half_length(n - 1) + half_length(0)));
        out[0] = out[n] = {out[0].strain + out[n].strain, out[n].curvature,
                           length_inverse * (out[0].energy + out[n].energy)};
    } else {
        for (const auto& [node, k] : {std::pair{0, 0}, std::pair{n, n - 1}}) {
            out[node].strain *= P(2.0);
            out[node].energy *= P(1 / half_length(k));
        }
    }
}

} // namespace detail

/// Profile of a tile across; `out` has a place per slot. Bodies are not strained. Slots are synchronised at `time`, s.
template <int W> void rod_profile(const RodTile<W>& rod, double time, NodeProfileOf<Pack<W>>* out) {
    const Pack<W> none(0.0);
    std::fill_n(out, rod.last + 1, NodeProfileOf<Pack<W>>{none, none, none});
    const Law law = rod.group->law();
    if (!rod.group->strained()) return;
    if (law == Law::elastica) detail::rod_profile<IncompressibleLaw, true>(rod, time, out);
    else with_energy_law(law, [&]<class L>(L) { detail::rod_profile<L, false>(rod, time, out); });
}

} // namespace skein
