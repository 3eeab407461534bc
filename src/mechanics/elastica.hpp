// Published rod (Gazzola et al. 2018, R. Soc. Open Sci. 5, 171628, as its authors discretise it), for comparison and
// replays. It has no energy: powers of the dilatation, a dilatation-rate term and the explicit gyroscopic term.
// theory.md (48)-(50)
//
//   element k      e = |dx|/l0,  sigma = Q dx/l0 - e3,  n = S (sigma - sigma0),  f = Q^T n/e
//   cell k|k+1     kappa = log(Q[k+1] Q[k]^T)/D,  tau = B (kappa - kappa0)/E^3,  E = mean length over D
//   couple         Dh[tau] + Ah[kappa x tau D] + (Q t x n) l0 + (J w/e) x w + (J w/e) e'/e,   e' = dx.dv/(|dx| l0)
//   kick           w += h e J^-1 c,   and the drift is Q <- R(h w) Q: J w x w stands in the couple
#pragma once

#include "core/rotation.hpp"
#include "mechanics/elastic.hpp"

namespace skein {

/// Rotation of the frame at the body's angular velocity, independent of its inertia.
struct PlainGyration {
    template <class C, int W>
    SKEIN_INLINE static void turn(const C&, Quaternion<Pack<W>>& q, Vec3<Pack<W>>& w, Pack<W> h) {
        q = rotation<W>(h * w) * q;
    }
};

template <int W> class ElasticaPass final : public TilePass<W> {
public:
    explicit ElasticaPass(Ends ends, std::shared_ptr<EndWalls<W>> walls = std::make_shared<EndWalls<W>>())
        : ends_(ends), walls_(std::move(walls)) {}

    void bind(const RodTile<W>& rod) override { walls_->bind(rod); }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        const int n = rod.n;
        using Walls = EndWalls<W>;
        Edge edge = edge_of(rod, 0);
        const Cell first =
            ends_.closed ? cell(rod, n - 1, 0, edge_of(rod, n - 1).e, edge.e)
            : ends_.start_wall
                ? wall(rod.group->start_wall,
                       relative_rotation(rod.slot[0].director, walls_->frame(Walls::start, rod, step)), edge.e)
                : Cell{};
        Cell before = first;
        Vec3<P> force_before{};
        for (int k = 0; k < n; ++k) {
            const bool last = k == n - 1;
            const Edge next = last ? edge : edge_of(rod, k + 1);
            const Cell after =
                !last          ? cell(rod, k, k + 1, edge.e, next.e)
                : ends_.closed ? first
                : ends_.end_wall
                    ? wall(rod.group->end_wall,
                           relative_rotation(walls_->frame(Walls::end, rod, step), rod.slot[k].director), edge.e)
                    : Cell{};
            const ElementConstants& c = rod.element[k];
            const Vec3<P> n_body = scale(broadcast<W>(c.stiffness),
                                         edge.nu - broadcast<W>(c.rest_strain) - Vec3<P>{P(0.0), P(0.0), P(1.0)});
            const P inv_e = P(1.0) / edge.e;
            const Vec3<P> force = inv_e * transpose_times(rod.slot[k].director, n_body);
            const Vec3<P> spin = rod.slot[k].spin, momentum = inv_e * scale(broadcast<W>(c.inertia), spin);
            load[k].force = force - force_before;
            load[k].dilatation = edge.e;
            load[k].couple = after.tau - before.tau + P(0.5) * (before.turn + after.turn) +
                             P(c.rest_length) * inv_e * cross(edge.nu, n_body) + cross(momentum, spin) +
                             edge.rate * inv_e * momentum;
            force_before = force;
            before = after;
            edge = next;
        }
        load[n].force = -force_before;
    }

private:
    using P = Pack<W>;
    struct Edge {
        Vec3<P> nu; ///< Q dx/l0
        P e, rate;  ///< |dx|/l0 and its rate, 1/s
    };
    struct Cell {
        Vec3<P> tau, turn; ///< B (kappa - kappa0)/E^3 and kappa x tau D, N m
    };

    static Edge edge_of(const RodTile<W>& rod, int k) {
        const Vec3<P> dx = rod.slot[k + 1].position - rod.slot[k].position,
                      dv = rod.slot[k + 1].velocity - rod.slot[k].velocity;
        const P inverse(rod.element[k].inv_rest_length), length = norm(dx);
        return {inverse * (rod.slot[k].director * dx), inverse * length, inverse * dot(dx, dv) / length};
    }
    static Cell loads(const Vec3<P>& phi, P dilatation, double inv_length, const Vec3d& stiffness,
                      const Vec3d& rest_curvature) {
        const Vec3<P> tau = P(1.0) / (dilatation * dilatation * dilatation) *
                            scale(broadcast<W>(stiffness), fma(P(inv_length), phi, -broadcast<W>(rest_curvature)));
        return {tau, cross(phi, tau)};
    }
    static Cell cell(const RodTile<W>& rod, int k, int next, P e, P e_next) {
        const VoronoiConstants& v = rod.voronoi[k];
        return loads(relative_rotation(rod.slot[next].director, rod.slot[k].director),
                     P(v.share_before) * e + P(v.share_after) * e_next, v.inv_length, v.stiffness, v.rest_curvature);
    }
    static Cell wall(const VoronoiConstants& v, const Vec3<P>& phi, P e) {
        return loads(phi, e, v.inv_length, v.stiffness, v.rest_curvature);
    }

    Ends ends_;
    std::shared_ptr<EndWalls<W>> walls_;
};

} // namespace skein
