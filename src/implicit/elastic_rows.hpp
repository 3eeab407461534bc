// Internal loads of a rod, and their stiffness row by row, for Newton corrections of displacements dx (lab) and turns t
// (body, Q <- R(t) Q).
//   element k    nu = Q (x[k+1] - x[k])/l,   d nu = [nu] t + Q (dx[k+1] - dx[k])/l,   n = n(s) + S (nu - s)
//                H = [nu] S - [n]:   d(l nu x n) = l H d nu,   d(Q^T n) = Q^T (S d nu + t x n)
//   cell k|k+1   phi = log(Q[k+1] Q[k]^T),   d phi = P t[k+1] - P^T t[k],   P = 1 + [phi]/2 + g [phi]^2
//                A = P K - [tau]/2,   A' = P^T K + [tau]/2,   K = f B/D
// The strains s are unknowns of their own, which follow the corrections linearly ("carried"), as those of equilibria
// do: a turn by t would otherwise stretch elements by t^2/2, whose forces exceed those of bending by (l/r)^2. Left out
// of the stiffness is what bending pulls on elements, of order (r kappa)^2 of the rest.   theory.md (115)
#pragma once

#include "implicit/block_rows.hpp"
#include "mechanics/elastic.hpp"

namespace skein {

template <class P> struct Three { P a[3][3]; };

namespace detail {

template <class P> SKEIN_INLINE Three<P> skew(const Vec3<P>& v) {
    const P zero(0.0);
    return {{{zero, -v.z, v.y}, {v.z, zero, -v.x}, {-v.y, v.x, zero}}};
}
template <class P> SKEIN_INLINE Three<P> product(const Three<P>& a, const Three<P>& b) {
    Three<P> r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            r.a[i][j] = fma(a.a[i][0], b.a[0][j], fma(a.a[i][1], b.a[1][j], a.a[i][2] * b.a[2][j]));
    return r;
}
template <class P> SKEIN_INLINE Three<P> product_with_transpose(const Three<P>& a, const Three<P>& b) {
    Three<P> r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            r.a[i][j] = fma(a.a[i][0], b.a[j][0], fma(a.a[i][1], b.a[j][1], a.a[i][2] * b.a[j][2]));
    return r;
}

/// Frame as a matrix whose rows are the directors.
template <int W> SKEIN_INLINE Three<Pack<W>> three(const Quaternion<Pack<W>>& q) {
    const Mat3<Pack<W>> m = matrix(q);
    return {{{m.d1.x, m.d1.y, m.d1.z}, {m.d2.x, m.d2.y, m.d2.z}, {m.d3.x, m.d3.y, m.d3.z}}};
}

} // namespace detail

template <class Law, int W> class ElasticRows {
public:
    using P = Pack<W>;
    using V = Vec3<P>;

    ElasticRows(Ends ends, const EndWalls<W>& walls) : ends_(ends), walls_(walls) {}

    /// Sets internal loads at carried strains, [n].
    void loads(const RodTile<W>& rod, const V* carried, const Step& step, SlotLoad<W>* load) const {
        const int n = rod.n;
        const CellLoads<P> seam = ends_.closed       ? of_cell(rod, carried, n - 1, 0)
                                  : ends_.start_wall ? of_start(rod, carried, step)
                                                     : CellLoads<P>{};
        CellLoads<P> before = seam;
        V force_before{};
        for (int k = 0; k < n; ++k) {
            const CellLoads<P> after = k + 1 < n        ? of_cell(rod, carried, k, k + 1)
                                       : ends_.closed   ? seam
                                       : ends_.end_wall ? of_end(rod, carried, step)
                                                        : CellLoads<P>{};
            const V nu = element_strain<Across<W>>(rod, k);
            V force_body = stress(rod, k, nu, carried[k]);
            if constexpr (Law::bending_pulls) force_body.z += before.tension + after.tension;
            const V force = transpose_times(rod.slot[k].director, force_body);
            load[k].force = force - force_before;
            load[k].couple = fma(P(rod.element[k].rest_length), cross(nu, force_body), before.after + after.before);
            load[k].dilatation = carried[k].z;
            force_before = force;
            before = after;
        }
        load[n].force = -force_before;
        load[n].couple = {};
    }

    /// Calls take(k, row) with the stiffness of each row, in order, from 0 to `last`.
    template <class Take>
    void stiffness(const RodTile<W>& rod, const V* carried, const Step& step, int last, Take&& take) const {
        const int n = rod.n;
        Cell before = ends_.closed ? cell(rod, carried, n - 1, 0) : start(rod, carried, step), seam = before;
        Element element_before = ends_.closed ? element(rod, n - 1, carried[n - 1]) : Element{};
        BlockRow<W> row;
        for (int k = 0; k < n; ++k) {
            const Cell after = k + 1 < n ? cell(rod, carried, k, k + 1) : ends_.closed ? seam : end(rod, carried, step);
            const Element own = element(rod, k, carried[k]);
            fill(row, element_before, own, before, after);
            take(k, row);
            element_before = own;
            before = after;
        }
        if (last < n) return;
        fill(row, element_before, {}, {}, {});
        take(n, row);
    }

    /// Strains that follow a correction linearly: nu + [nu] t + Q (dx[k+1] - dx[k])/l.
    static V followed(const RodTile<W>& rod, int k, const V& nu, const V& apart, const V& turn) {
        return fma(P(rod.element[k].inv_rest_length), rod.slot[k].director * apart, nu + cross(nu, turn));
    }

private:
    struct Element {
        Three<P> xx{}, tx{}, tt{}; ///< between its nodes; of its turn by a node; of its turn
    };
    struct Cell {
        Three<P> bb{}, ba{}, ab{}, aa{}; ///< of the elements before and after
    };

    /// n(s) + S (nu - s)
    static V stress(const RodTile<W>& rod, int k, const V& nu, const V& s) {
        const ElementConstants& c = rod.element[k];
        const V stiff{P(c.stiffness.x), P(c.stiffness.y), Law::stretch_stiffness(c, s.z)};
        return Law::stress(c, s) + scale(stiff, nu - s);
    }

    P inv_dilatation(const RodTile<W>& rod, const V* carried, int k, int next) const {
        const VoronoiConstants& v = rod.voronoi[k];
        if constexpr (Law::bending_pulls)
            return P(1.0) / fma(P(v.share_before), carried[k].z, P(v.share_after) * carried[next].z);
        else return P(1.0);
    }
    CellLoads<P> of_cell(const RodTile<W>& rod, const V* carried, int k, int next) const {
        const VoronoiConstants& v = rod.voronoi[k];
        return cell_loads<Law, W>({relative_rotation_and_jacobian(rod.slot[next].director, rod.slot[k].director),
                                   inv_dilatation(rod, carried, k, next)},
                                  v.inv_length, v.stiffness, v.rest_curvature, rod.element[k].rest_stretch);
    }
    CellLoads<P> of_start(const RodTile<W>& rod, const V* carried, const Step& step) const {
        return of_half(rod.group->start_wall, rod.slot[0].director, walls_.frame(EndWalls<W>::start, rod, step),
                       carried[0].z, rod.element[0].rest_stretch);
    }
    CellLoads<P> of_end(const RodTile<W>& rod, const V* carried, const Step& step) const {
        const int k = rod.n - 1;
        return of_half(rod.group->end_wall, walls_.frame(EndWalls<W>::end, rod, step), rod.slot[k].director,
                       carried[k].z, rod.element[k].rest_stretch);
    }
    static CellLoads<P> of_half(const VoronoiConstants& half, const Quaternion<P>& after, const Quaternion<P>& before,
                                const P& e, double rest_stretch) {
        return cell_loads<Law, W>({relative_rotation_and_jacobian(after, before), P(1.0) / e}, half.inv_length,
                                  half.stiffness, half.rest_curvature, rest_stretch);
    }

    static Element element(const RodTile<W>& rod, int k, const V& s) {
        const ElementConstants& c = rod.element[k];
        const V nu = element_strain<Across<W>>(rod, k), n = stress(rod, k, nu, s);
        const P sx(c.stiffness.x), sy(c.stiffness.y), sz = Law::stretch_stiffness(c, s.z), zero(0.0);
        const Three<P> h{{{zero, fnma(nu.z, sy, n.z), fms(nu.y, sz, n.y)},
                          {fms(nu.z, sx, n.z), zero, fnma(nu.x, sz, n.x)},
                          {fnma(nu.y, sx, n.y), fms(nu.x, sy, n.x), zero}}};
        const Three<P> q = detail::three<W>(rod.slot[k].director);
        Element e;
        const P inv(c.inv_rest_length), s3[3] = {sx * inv, sy * inv, sz * inv};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                e.xx.a[i][j] =
                    fma(s3[0] * q.a[0][i], q.a[0][j], fma(s3[1] * q.a[1][i], q.a[1][j], s3[2] * q.a[2][i] * q.a[2][j]));
        e.tx = detail::product(h, q);
        const Three<P> turned = detail::product(h, detail::skew(nu));
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) e.tt.a[i][j] = P(-c.rest_length) * turned.a[i][j];
        return e;
    }

    /// `stiff`: f B/D.
    static Cell of_turn(const RelativeRotation<P>& turn, const V& stiff, const V& tau) {
        const V& f = turn.log;
        const P half(0.5), g = turn.jacobian, squared = dot(f, f);
        Three<P> p; // P = 1 + [phi]/2 + g (phi phi^T - |phi|^2)
        const P comp[3] = {f.x, f.y, f.z};
        const Three<P> by = detail::skew(half * f), turning = detail::skew(half * tau);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                p.a[i][j] = fma(g * comp[i], comp[j], by.a[i][j]);
                if (i == j) p.a[i][j] += fnma(g, squared, P(1.0));
            }
        const P k[3] = {stiff.x, stiff.y, stiff.z};
        Three<P> a, other;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                a.a[i][j] = fms(p.a[i][j], k[j], turning.a[i][j]);
                other.a[i][j] = fma(p.a[j][i], k[j], turning.a[i][j]);
            }
        Cell c{detail::product_with_transpose(a, p), detail::product(a, p), detail::product_with_transpose(other, p),
               detail::product(other, p)};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                c.ba.a[i][j] = -c.ba.a[i][j];
                c.ab.a[i][j] = -c.ab.a[i][j];
            }
        return c;
    }
    static Cell of_constants(const RelativeRotation<P>& turn, const P& inv_dilatation, const VoronoiConstants& v,
                             double rest_stretch) {
        const auto factor = Law::bending_factor(inv_dilatation, rest_stretch);
        const V stiff = (factor * P(v.inv_length)) * broadcast<W>(v.stiffness);
        const V strain = fma(P(v.inv_length), turn.log, -broadcast<W>(v.rest_curvature));
        return of_turn(turn, stiff, factor * scale(broadcast<W>(v.stiffness), strain));
    }
    Cell cell(const RodTile<W>& rod, const V* carried, int k, int next) const {
        return of_constants(relative_rotation_and_jacobian(rod.slot[next].director, rod.slot[k].director),
                            inv_dilatation(rod, carried, k, next), rod.voronoi[k], rod.element[k].rest_stretch);
    }
    Cell start(const RodTile<W>& rod, const V* carried, const Step& step) const {
        if (!ends_.start_wall) return {};
        return of_constants(
            relative_rotation_and_jacobian(rod.slot[0].director, walls_.frame(EndWalls<W>::start, rod, step)),
            P(1.0) / carried[0].z, rod.group->start_wall, rod.element[0].rest_stretch);
    }
    Cell end(const RodTile<W>& rod, const V* carried, const Step& step) const {
        if (!ends_.end_wall) return {};
        const int k = rod.n - 1;
        return of_constants(
            relative_rotation_and_jacobian(walls_.frame(EndWalls<W>::end, rod, step), rod.slot[k].director),
            P(1.0) / carried[k].z, rod.group->end_wall, rod.element[k].rest_stretch);
    }

    static void fill(BlockRow<W>& row, const Element& element_before, const Element& own, const Cell& before,
                     const Cell& after) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                const P zero(0.0);
                row.diagonal[i][j] = element_before.xx.a[i][j] + own.xx.a[i][j];
                row.diagonal[i][3 + j] = own.tx.a[j][i];
                row.diagonal[3 + i][j] = own.tx.a[i][j];
                row.diagonal[3 + i][3 + j] = own.tt.a[i][j] + before.aa.a[i][j] + after.bb.a[i][j];
                row.before[i][j] = -element_before.xx.a[i][j];
                row.before[i][3 + j] = -element_before.tx.a[j][i];
                row.before[3 + i][j] = zero;
                row.before[3 + i][3 + j] = before.ab.a[i][j];
                row.after[i][j] = -own.xx.a[i][j];
                row.after[i][3 + j] = zero;
                row.after[3 + i][j] = -own.tx.a[i][j];
                row.after[3 + i][3 + j] = after.ba.a[i][j];
            }
    }

    Ends ends_;
    const EndWalls<W>& walls_;
};

} // namespace skein
