// Block-tridiagonal systems along a rod, without symmetry: one block row per node and its element, one rod a lane.
//   open      D[k] u[k] + L[k] u[k-1] + U[k] u[k+1] = b[k]
//   ring      L of the first row belongs to the last unknowns, and U of the last row to the first
// Rows are eliminated as they come, so that none is kept: what remains of row k is u[k] = y[k] - X[k] u[k+1] - Z[k]
// u[last], with Z in rings alone. No pivots are sought: inertia, bending and stretch make the diagonal blocks positive.
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "skein/core/pack.hpp"

namespace skein {

inline constexpr int row_size = 6; ///< displacement of the node, turn of its element

template <int W> using RowBlock = Pack<W>[row_size][row_size];

template <int W> void clear(RowBlock<W>& block) {
    for (auto& line : block)
        for (Pack<W>& entry : line) entry = Pack<W>(0.0);
}

/// Row of the system.
template <int W> struct BlockRow {
    RowBlock<W> diagonal, before, after;
    Pack<W> right[row_size];

    void clear() {
        skein::clear<W>(diagonal);
        skein::clear<W>(before);
        skein::clear<W>(after);
    }
    /// Holds unknown i at 0.
    void hold(int i) {
        for (int j = 0; j < row_size; ++j) diagonal[i][j] = before[i][j] = after[i][j] = Pack<W>(0.0);
        diagonal[i][i] = Pack<W>(1.0);
        right[i] = Pack<W>(0.0);
    }
};

/// Unknowns of a row.
template <int W> struct RowVector { Pack<W> u[row_size]; };

namespace detail {

/// m <- d^-1 m by elimination; d is spent.
template <int Columns, int W> void solve_block(RowBlock<W>& d, Pack<W> (&m)[row_size][Columns]) {
    using P = Pack<W>;
    for (int j = 0; j < row_size; ++j) {
        const P inverse = P(1.0) / d[j][j];
        for (int c = j + 1; c < row_size; ++c) d[j][c] = inverse * d[j][c];
        for (int c = 0; c < Columns; ++c) m[j][c] = inverse * m[j][c];
        for (int i = j + 1; i < row_size; ++i) {
            const P factor = d[i][j];
            for (int c = j + 1; c < row_size; ++c) d[i][c] = fnma(factor, d[j][c], d[i][c]);
            for (int c = 0; c < Columns; ++c) m[i][c] = fnma(factor, m[j][c], m[i][c]);
        }
    }
    for (int j = row_size - 1; j > 0; --j)
        for (int i = 0; i < j; ++i) {
            const P factor = d[i][j];
            for (int c = 0; c < Columns; ++c) m[i][c] = fnma(factor, m[j][c], m[i][c]);
        }
}

/// a -= l m, of the first columns of m.
template <int Columns, int W>
void subtract(const RowBlock<W>& l, const Pack<W> (&m)[row_size][Columns], int first, RowBlock<W>& a) {
    for (int i = 0; i < row_size; ++i)
        for (int j = 0; j < row_size; ++j)
            for (int c = 0; c < row_size; ++c) a[i][c] = fnma(l[i][j], m[j][first + c], a[i][c]);
}
template <int W, class Of> void subtract(const RowBlock<W>& l, const Of& of, Pack<W> (&b)[row_size]) {
    for (int i = 0; i < row_size; ++i)
        for (int j = 0; j < row_size; ++j) b[i] = fnma(l[i][j], of(j), b[i]);
}

} // namespace detail

/// Elimination of the rows of W rods alike.
template <int W> class BlockRows {
public:
    using P = Pack<W>;

    /// Makes room for rows 0 to `last`; a ring has three at least.
    void begin(int last, bool ring) {
        last_ = last;
        ring_ = ring;
        if (kept_.size() <= to_index(last)) kept_.resize(to_index(last) + 1);
        if (ring && across_.size() <= to_index(last)) across_.resize(to_index(last) + 1);
    }

    /// Takes row k, in order. The row is spent.
    void add(int k, BlockRow<W>& row) {
        if (ring_) return add_of_ring(k, row);
        Kept& kept = kept_[to_index(k)];
        if (k > 0) {
            const Kept& prior = kept_[to_index(k - 1)];
            detail::subtract<row_size + 1, W>(row.before, prior.m, 0, row.diagonal);
            detail::subtract<W>(
                row.before, [&](int j) -> const P& { return prior.m[j][row_size]; }, row.right);
        }
        put(kept, row);
        detail::solve_block<row_size + 1, W>(row.diagonal, kept.m);
    }

    /// Unknowns of all rows, once the last has been taken.
    void solve(RowVector<W>* out) const {
        for (int k = last_; k >= 0; --k) {
            const Kept& kept = kept_[to_index(k)];
            RowVector<W>& u = out[k];
            for (int i = 0; i < row_size; ++i) u.u[i] = kept.m[i][row_size];
            if (k == last_) continue;
            if (!(ring_ && k + 1 == last_))
                for (int i = 0; i < row_size; ++i)
                    for (int j = 0; j < row_size; ++j) u.u[i] = fnma(kept.m[i][j], out[k + 1].u[j], u.u[i]);
            if (ring_)
                for (int i = 0; i < row_size; ++i)
                    for (int j = 0; j < row_size; ++j)
                        u.u[i] = fnma(across_[to_index(k)].to_last[i][j], out[last_].u[j], u.u[i]);
        }
    }

private:
    /// X and y of a row.
    struct Kept {
        P m[row_size][row_size + 1];
    };
    /// Z of a row.
    struct Across {
        RowBlock<W> to_last;
    };

    static void put(Kept& kept, const BlockRow<W>& row) {
        for (int i = 0; i < row_size; ++i) {
            for (int j = 0; j < row_size; ++j) kept.m[i][j] = row.after[i][j];
            kept.m[i][row_size] = row.right[i];
        }
    }

    void add_of_ring(int k, BlockRow<W>& row) {
        constexpr int all = 2 * row_size + 1; // X, y, Z
        P m[row_size][all];
        RowBlock<W> to_last; // coupling to the last unknowns
        clear<W>(to_last);
        if (k == 0) {
            for (int i = 0; i < row_size; ++i)
                for (int j = 0; j < row_size; ++j) to_last[i][j] = row.before[i][j];
        } else if (k < last_) {
            const Kept& prior = kept_[to_index(k - 1)];
            detail::subtract<row_size + 1, W>(row.before, prior.m, 0, row.diagonal);
            detail::subtract<row_size, W>(row.before, across_[to_index(k - 1)].to_last, 0, to_last);
            detail::subtract<W>(
                row.before, [&](int j) -> const P& { return prior.m[j][row_size]; }, row.right);
        }
        if (k == last_) return finish_ring(row);
        if (k + 1 == last_) // both couplings are to the last unknowns
            for (int i = 0; i < row_size; ++i)
                for (int j = 0; j < row_size; ++j) {
                    to_last[i][j] += row.after[i][j];
                    row.after[i][j] = P(0.0);
                }
        for (int i = 0; i < row_size; ++i) {
            for (int j = 0; j < row_size; ++j) {
                m[i][j] = row.after[i][j];
                m[i][row_size + 1 + j] = to_last[i][j];
            }
            m[i][row_size] = row.right[i];
        }
        detail::solve_block<all, W>(row.diagonal, m);
        Kept& kept = kept_[to_index(k)];
        RowBlock<W>& z = across_[to_index(k)].to_last;
        for (int i = 0; i < row_size; ++i) {
            for (int j = 0; j <= row_size; ++j) kept.m[i][j] = m[i][j];
            for (int j = 0; j < row_size; ++j) z[i][j] = m[i][row_size + 1 + j];
        }
    }

    /// The last row is coupled to the first: its coupling moves on from row to row.
    void finish_ring(BlockRow<W>& row) {
        RowBlock<W> l, next;
        for (int i = 0; i < row_size; ++i)
            for (int j = 0; j < row_size; ++j) l[i][j] = row.after[i][j];
        for (int k = 0; k < last_; ++k) {
            const Kept& kept = kept_[to_index(k)];
            if (k + 1 == last_)
                for (int i = 0; i < row_size; ++i)
                    for (int j = 0; j < row_size; ++j) l[i][j] += row.before[i][j];
            detail::subtract<row_size, W>(l, across_[to_index(k)].to_last, 0, row.diagonal);
            detail::subtract<W>(
                l, [&](int j) -> const P& { return kept.m[j][row_size]; }, row.right);
            clear<W>(next);
            detail::subtract<row_size + 1, W>(l, kept.m, 0, next);
            for (int i = 0; i < row_size; ++i)
                for (int j = 0; j < row_size; ++j) l[i][j] = next[i][j];
        }
        Kept& kept = kept_[to_index(last_)];
        for (int i = 0; i < row_size; ++i) {
            for (int j = 0; j < row_size; ++j) kept.m[i][j] = P(0.0);
            kept.m[i][row_size] = row.right[i];
        }
        detail::solve_block<row_size + 1, W>(row.diagonal, kept.m);
    }

    int last_ = 0;
    bool ring_ = false;
    AlignedVector<Kept> kept_;
    AlignedVector<Across> across_;
};

} // namespace skein
