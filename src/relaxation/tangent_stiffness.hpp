// Present stiffness of a rod, made positive: the inertia of relaxation. theory.md (65)
//   element   y = dx[k+1] - dx[k] - t x X,    y.C y,  C = Q^T S Q/l, S tangent;  y = change of X = x[k+1] - x[k]
//             without the turn
//             (dx[k+1] - dx[k])^2 N/l         for tension N > 0: transverse stiffness of a string
//   cell      (t[k+1] - t[k]).B (t[k+1] - t[k])/(D E^3), B in the lab, the mean of both elements' frames
//   moments   t^2 q D/4
//   wall      t.B t/(D E^3)
// Displacements dx and turns t are lab vectors.
#pragma once

#include "mechanics/elastic.hpp"
#include "relaxation/block_band.hpp"

namespace skein {

template <class Law, int W> class TangentStiffness {
public:
    using P = Pack<W>;
    using Block = BandBlock<W>;

    /// Adds the stiffness of a rod to its blocks, [n + 1]; a ring has [n], the last of which is coupled to the first.
    static void add(const RodTile<W>& rod, const Ends& ends, Block* block) {
        const int n = rod.n;
        Vec3<P> nu = element_strain<Across<W>>(rod, 0);
        for (int k = 0; k < n; ++k) {
            const ElementConstants& c = rod.element[k];
            const Mat3<P> q = matrix(rod.slot[k].director);
            const int next = ends.closed && k == n - 1 ? 0 : k + 1;
            stretch(rod, c, q, nu, k, block[k], block[next]);
            const auto wall = [&](const VoronoiConstants& half) {
                const auto factor = Law::bending_factor(P(1.0) / nu.z, c.rest_stretch) * P(half.inv_length);
                add_turning(block[k], in_lab(q, factor * broadcast<W>(half.stiffness)));
            };
            if (k == 0 && ends.start_wall) wall(rod.group->start_wall);
            if (k == n - 1 && ends.end_wall) wall(rod.group->end_wall);
            if (next == n) break;
            const Vec3<P> nu_next = element_strain<Across<W>>(rod, next);
            bend(rod, q, nu.z, nu_next.z, k, next, block);
            nu = nu_next;
        }
    }

private:
    struct Tensor {
        P a[3][3];
    };
    /// Q^T diag(d) Q.
    static Tensor in_lab(const Mat3<P>& q, const Vec3<P>& d) {
        const P rows[3][3] = {{q.d1.x, q.d1.y, q.d1.z}, {q.d2.x, q.d2.y, q.d2.z}, {q.d3.x, q.d3.y, q.d3.z}};
        Tensor t;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                t.a[i][j] =
                    fma(d.x * rows[0][i], rows[0][j], fma(d.y * rows[1][i], rows[1][j], d.z * rows[2][i] * rows[2][j]));
        return t;
    }
    /// Adds a stiffness against turns that strain nothing else, onto the diagonal.
    static void add_turning(BandBlock<W>& b, const Tensor& t) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) b.diagonal[3 + i][3 + j] += t.a[i][j];
    }

    /// Stretch and shear of element k, and tension.
    static void stretch(const RodTile<W>& rod, const ElementConstants& c, const Mat3<P>& q, const Vec3<P>& nu, int k,
                        Block& b, Block& after) {
        const P inv_length(c.inv_rest_length);
        const Vec3<P> stiffness{P(c.stiffness.x), P(c.stiffness.y), Law::stretch_stiffness(c, nu.z)};
        const Tensor s = in_lab(q, inv_length * stiffness);
        const P pull = max(Law::stress(c, nu).z, P(0.0)) * inv_length;
        const Vec3<P> x = rod.slot[k + 1].position - rod.slot[k].position;
        // y = dx' - dx + X t, X = [x]
        const P zero(0.0), X[3][3] = {{zero, -x.z, x.y}, {x.z, zero, -x.x}, {-x.y, x.x, zero}};
        P sx[3][3];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                sx[i][j] = fma(s.a[i][0], X[0][j], fma(s.a[i][1], X[1][j], s.a[i][2] * X[2][j]));
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                const P along = i == j ? s.a[i][j] + pull : s.a[i][j];
                b.diagonal[i][j] += along;
                after.diagonal[i][j] += along;
                b.next[i][j] -= along;
                b.diagonal[3 + j][i] -= sx[i][j];
                b.next[i][3 + j] += sx[i][j];
                b.diagonal[3 + i][3 + j] += fma(X[0][i], sx[0][j], fma(X[1][i], sx[1][j], X[2][i] * sx[2][j]));
            }
    }

    /// Bending and twist between elements k and `next`.
    static void bend(const RodTile<W>& rod, const Mat3<P>& q, P e, P e_next, int k, int next, Block* block) {
        const VoronoiConstants& v = rod.voronoi[k];
        const Mat3<P> q_next = matrix(rod.slot[next].director);
        const auto factor = Law::bending_factor(P(1.0) / fma(P(v.share_before), e, P(v.share_after) * e_next),
                                                rod.element[k].rest_stretch);
        const Vec3<P> half = (factor * P(0.5 * v.inv_length)) * broadcast<W>(v.stiffness);
        const Tensor one = in_lab(q, half), other = in_lab(q_next, half);
        Tensor s;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) s.a[i][j] = one.a[i][j] + other.a[i][j];
        Block &b = block[k], &after = block[next];
        add_turning(b, s);
        add_turning(after, s);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) b.next[3 + i][3 + j] -= s.a[i][j];
        const Vec3<P> phi = relative_rotation(rod.slot[next].director, rod.slot[k].director);
        const Vec3<P> strain = fma(P(v.inv_length), phi, -broadcast<W>(v.rest_curvature));
        const P moments = P(0.25 / v.inv_length) * dot(strain, factor * scale(broadcast<W>(v.stiffness), strain));
        b.add(3, moments);
        after.add(3, moments);
    }
};

} // namespace skein
