// Internal forces and couples: the exact negative gradient of the discrete energy, in one sweep along the rod.
//   theory.md (8)-(15); derivation there, checked against finite differences of the energy in
//   tests/unit/rod/elastic_test.cpp
//
//   element k      nu = Q (x[k+1]-x[k])/l0,  e = nu_3,  n = dWs/dnu             [N] body
//                  f[k] += Q^T n,  f[k+1] -= Q^T n,  c[k] += l0 nu x n
//   cell k|k+1     phi = log(Q[k+1] Q[k]^T),  kappa = phi/D,  tau = B (kappa-kappa0)/E^3
//                  a = phi x tau,  b = g(phi) phi x a
//                  c[k] += tau + a/2 + b,   c[k+1] += -tau + a/2 - b
//                  n_3 -= (3/4) q/E^4 in both elements, q = (kappa-kappa0).B(kappa-kappa0); the law gives E^-3 and this
//   ring           one more cell, between elements n-1 and 0
//   wall           a half cell, D = l0/2, between the wall's frame and the first or last element; E = that element's e
//
// Cost: 211 flop per element. Reads x, Q; writes force and couple.
#pragma once

#include "core/rotation.hpp"
#include "mechanics/law.hpp"
#include "mechanics/moving_ends.hpp"
#include "skein/core/aligned.hpp"
#include "skein/tiles/mapping.hpp"
#include "skein/tiles/tile.hpp"

#include <memory>
#include <utility>

namespace skein {

/// Strain of a Voronoi cell or half cell.
template <class P> struct CellStrain {
    RelativeRotation<P> turn; ///< phi and g
    P inv_dilatation;         ///< 1/E
};

/// Loads of a Voronoi cell or half cell on the elements before and after it.
template <class P> struct CellLoads {
    Vec3<P> before, after; ///< couples, N m, body components of each element
    P tension;             ///< force added to n_3 of both, N
};

/// N and V: length, stiffness, rest curvature and rest stretch e0 as numbers or as packs.
template <class Law, int W, class N, class V>
SKEIN_INLINE CellLoads<Pack<W>> cell_loads(const CellStrain<Pack<W>>& cell, const N& inv_length, const V& stiffness,
                                           const V& rest_curvature, const N& rest_stretch) {
    using P = Pack<W>;
    const Vec3<P>& phi = cell.turn.log;
    const Vec3<P> strain = fma(P(inv_length), phi, -broadcast<W>(rest_curvature));
    const Vec3<P> moment = scale(broadcast<W>(stiffness), strain);
    const auto factor = Law::bending_factor(cell.inv_dilatation, rest_stretch);
    const Vec3<P> tau = Law::bending_pulls ? factor * moment : moment;
    const Vec3<P> a = cross(phi, tau);
    const Vec3<P> straight = fma(cell.turn.jacobian, cross(phi, a), tau); // tau + b
    const P half(0.5);
    CellLoads<P> loads{fma(half, a, straight),
                       {fms(half, a.x, straight.x), fms(half, a.y, straight.y), fms(half, a.z, straight.z)},
                       {}};
    if constexpr (Law::bending_pulls)
        loads.tension = Law::bending_tension(strain, moment, factor, cell.inv_dilatation, rest_stretch);
    return loads;
}

/// Ends of a rod: held by half cells, or joined to each other.
struct Ends {
    bool start_wall = false, end_wall = false, closed = false;
};
inline Ends ends_of(const RodGroup& group) {
    return {group.spec().start == EndKind::clamped, group.spec().end == EndKind::clamped, group.closed()};
}

template <class Law, int W, class Map = Across<W>> class ElasticPass final : public TilePass<W> {
public:
    /// `walls`: of clamped ends of rods across; null where no other pass shares them.
    explicit ElasticPass(Ends ends, std::shared_ptr<EndWalls<W>> walls = nullptr)
        : ends_(ends), walls_(walls ? std::move(walls) : std::make_shared<EndWalls<W>>()) {}

    void bind(const RodTile<W>& rod) override {
        if (!Map::along && (ends_.start_wall || ends_.end_wall)) walls_->bind(rod);
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        if constexpr (Map::along) join(rod);
        const Slot<W>* slot = rod.slot;
        const int n = rod.n;
        // The last step of a sweep prefetches the next tile, which hardware does not foresee.
        const Slot<W>* next_tile = step.last ? slot + n + 1 : slot;

        Vec3<P> nu = strain(rod, 0), force_before{};
        // One cell serves both sides where a ring closes, or where a lane's rod goes on in the next. It is computed
        // first.
        CellLoads<P> seam, before;
        if constexpr (Map::along) {
            seam = loads(rod, n - 1, cell(rod, n - 1, n, strain(rod, n - 1).z, from_lane_after(nu.z)));
            before =
                from_seam(rod.strands->first, seam, ends_.start_wall ? start_wall(rod, step, nu.z) : CellLoads<P>{});
        } else {
            seam = ends_.closed       ? loads(rod, n - 1, cell(rod, n - 1, 0, strain(rod, n - 1).z, nu.z))
                   : ends_.start_wall ? start_wall(rod, step, nu.z)
                                      : CellLoads<P>{};
            before = seam;
        }
        const auto finish = [&](int k, const CellLoads<P>& after) __attribute__((always_inline)) {
            Vec3<P> n_body = Law::stress(Map::element(rod, k), nu);
            if constexpr (Law::bending_pulls) n_body.z += before.tension + after.tension;
            const Vec3<P> force = transpose_times(slot[k].director, n_body);
            load[k].force = force - force_before;
            load[k].couple = fma(P(Map::element(rod, k).rest_length), cross(nu, n_body), before.after + after.before);
            load[k].dilatation = nu.z;
            force_before = force;
            before = after;
        };

        int k = 0;
        if (n > 1) {
            // Strains of a cell are computed one element ahead of its loads: two chains of arithmetic in flight instead
            // of one.
            Vec3<P> nu_next = strain(rod, 1);
            CellStrain<P> next = cell(rod, 0, 1, nu.z, nu_next.z);
            for (; k < n - 2; ++k) {
                prefetch(next_tile[k]);
                const Vec3<P> nu_ahead = strain(rod, k + 2);
                const CellStrain<P> ahead = cell(rod, k + 1, k + 2, nu_next.z, nu_ahead.z);
                finish(k, loads(rod, k, next));
                nu = nu_next;
                nu_next = nu_ahead;
                next = ahead;
            }
            finish(k, loads(rod, k, next));
            nu = nu_next;
            ++k;
        }
        finish(k, Map::along || ends_.closed ? seam : ends_.end_wall ? end_wall(rod, step, nu.z) : CellLoads<P>{});
        load[n].force = -force_before;
        if constexpr (Map::along)
            load[0].force += select(rod.strands->first, Vec3<P>{}, from_lane_before(load[n].force));
    }

    /// Couples of the half cells on the walls, body of the wall, N m; 0 without half cells.
    Vec3<Pack<W>> couple_on_start_wall(const RodTile<W>& rod, const Step& step) const {
        return ends_.start_wall ? start_wall(rod, step, strain(rod, 0).z).before : Vec3<Pack<W>>{};
    }
    Vec3<Pack<W>> couple_on_end_wall(const RodTile<W>& rod, const Step& step) const {
        return ends_.end_wall ? end_wall(rod, step, strain(rod, rod.n - 1).z).after : Vec3<Pack<W>>{};
    }

private:
    using P = Pack<W>;

    /// Loads from the lane before, and `otherwise` in lanes where a rod begins.
    static CellLoads<P> from_seam(Mask<W> begins, const CellLoads<P>& seam, const CellLoads<P>& otherwise) {
        return {otherwise.before, select(begins, otherwise.after, from_lane_before(seam.after)),
                select(begins, otherwise.tension, from_lane_before(seam.tension))};
    }

    SKEIN_INLINE static Vec3<P> strain(const RodTile<W>& rod, int k) { return element_strain<Map>(rod, k); }
    SKEIN_INLINE static CellStrain<P> cell(const RodTile<W>& rod, int k, int next, P e, P e_next) {
        const auto& v = Map::cell(rod, k);
        return {relative_rotation_and_jacobian(neighbour_frame<Map>(rod, k, next), rod.slot[k].director),
                Law::bending_pulls ? P(1.0) / fma(P(v.share_before), e, P(v.share_after) * e_next) : P(1.0)};
    }
    SKEIN_INLINE static CellLoads<P> loads(const RodTile<W>& rod, int k, const CellStrain<P>& cell) {
        const auto& v = Map::cell(rod, k);
        return cell_loads<Law, W>(cell, v.inv_length, v.stiffness, v.rest_curvature, Map::element(rod, k).rest_stretch);
    }
    template <class C, class R> [[gnu::noinline]] static CellLoads<P>
    wall(const C& cell, const Quaternion<P>& after, const Quaternion<P>& before, P e, const R& rest_stretch) {
        return cell_loads<Law, W>({relative_rotation_and_jacobian(after, before), P(1.0) / e}, cell.inv_length,
                                  cell.stiffness, cell.rest_curvature, rest_stretch);
    }
    CellLoads<P> start_wall(const RodTile<W>& rod, const Step& step, P e) const {
        if constexpr (Map::along) {
            const Strands<W>& s = *rod.strands;
            // Without a wall the element's frame stands for the wall's, so that no large angle is computed in vain.
            const Quaternion<P>& first = rod.slot[0].director;
            const CellLoads<P> held =
                wall(s.start_cell, first, select(s.start_wall, s.start_frame, first), e, s.element[0].rest_stretch);
            return {held.before, select(s.start_wall, held.after, Vec3<P>{}),
                    select(s.start_wall, held.tension, P(0.0))};
        } else {
            return wall(rod.group->start_wall, rod.slot[0].director, walls_->frame(EndWalls<W>::start, rod, step), e,
                        rod.element[0].rest_stretch);
        }
    }
    CellLoads<P> end_wall(const RodTile<W>& rod, const Step& step, P e) const {
        return wall(rod.group->end_wall, walls_->frame(EndWalls<W>::end, rod, step), rod.slot[rod.n - 1].director, e,
                    rod.element[rod.n - 1].rest_stretch);
    }

    Ends ends_;
    std::shared_ptr<EndWalls<W>> walls_;
};

} // namespace skein
