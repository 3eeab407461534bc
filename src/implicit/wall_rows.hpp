// Slopes of the loads of walls in the rows of a rod or body.                                          theory.md (134)
#pragma once

#include "contact/implicit_walls.hpp"
#include "implicit/contact_rows.hpp"

namespace skein {

/// Takes these slopes from the row of slot k. Turns are those of the elements, or (`in_lab`) of the lab.
template <int W> class WallRows {
public:
    using P = Pack<W>;
    WallRows(const WallSlopes<W>& slopes, const RodTile<W>& rod, bool in_lab)
        : slopes_(slopes), rod_(rod), in_lab_(in_lab), ring_(rod.group->closed()) {}

    void subtract_from(int k, BlockRow<W>& row) const {
        if (!slopes_.touches) return;
        if (slopes_.point.empty()) return subtract_body(row);
        subtract_node(k, row);
        if (k < rod_.n) subtract_element(k, row);
    }

private:
    using Matrix = Three<P>;

    static Matrix matrix(const P (&m)[3][3]) {
        Matrix r;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) r.a[i][j] = m[i][j];
        return r;
    }
    Matrix to_frame(int element, const Matrix& m) const {
        return in_lab_ ? m : detail::product(detail::three<W>(rod_.slot[element].director), m);
    }
    Matrix by_frame(int element, const Matrix& m) const {
        return in_lab_ ? m : detail::product_with_transpose(m, detail::three<W>(rod_.slot[element].director));
    }
    int before(int node) const { return node > 0 ? node - 1 : ring_ ? rod_.n - 1 : 0; }
    int after(int node) const { return node < rod_.n ? node : rod_.n - 1; }
    /// Block of row k for what stands in row `of`, the same or one beside it.
    RowBlock<W>& block(int k, int of, BlockRow<W>& row) const {
        if (of == k) return row.diagonal;
        const bool behind = of == k - 1 || (ring_ && k == 0 && of == rod_.n - 1);
        return behind ? row.before : row.after;
    }

    /// Force on a node, by itself and by both of its elements.
    void subtract_node(int k, BlockRow<W>& row) const {
        const auto& point = slopes_.point[to_index(k)];
        detail::add_three<W>(matrix(point.force), row.diagonal, 0, 0, -1);
        for (const int e : {before(k), after(k)})
            detail::add_three<W>(by_frame(e, matrix(point.force_by_turn)), block(k, e, row), 0, 3, -0.5);
    }
    /// Couples on an element: half of those at each of its nodes, all at an end.
    void subtract_element(int k, BlockRow<W>& row) const {
        for (const int at : {k, k + 1}) {
            const int node = ring_ && at == rod_.n ? 0 : at;
            const auto& point = slopes_.point[to_index(node)];
            const double share = 0.5 * ((before(node) == k) + (after(node) == k));
            detail::add_three<W>(to_frame(k, matrix(point.couple)), block(k, node, row), 3, 0, -share);
            for (const int e : {before(node), after(node)})
                detail::add_three<W>(by_frame(e, to_frame(k, matrix(point.couple_by_turn))), block(k, e, row), 3, 3,
                                     -0.5 * share);
        }
    }
    void subtract_body(BlockRow<W>& row) const {
        RowBlock<W> lab;
        for (int i = 0; i < row_size; ++i)
            for (int j = 0; j < row_size; ++j) lab[i][j] = -slopes_.body[i][j];
        if (in_lab_) {
            for (int i = 0; i < row_size; ++i)
                for (int j = 0; j < row_size; ++j) row.diagonal[i][j] += lab[i][j];
            return;
        }
        const Quaternion<P>& q = rod_.slot[0].director;
        add_lab_tangent<W>(lab, q, row.diagonal);
        detail::add_three<W>(detail::skew(q * slopes_.couple), row.diagonal, 3, 3, -1);
    }

    const WallSlopes<W>& slopes_;
    const RodTile<W>& rod_;
    bool in_lab_, ring_;
};

} // namespace skein
