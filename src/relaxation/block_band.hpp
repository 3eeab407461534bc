// Block-tridiagonal systems along a rod: symmetric and positive, with one block per node and its element.
//   A = G G^T, block by block along the rod; G y = b on the way, G^T u = y on the way back.      One rod a lane.
//   ring      the last block is coupled to the first as well: its coupling moves on from block to block during
//             elimination, as a second off-diagonal of G
// A block has 6 unknowns: displacement of the node, turn of its element.
#pragma once

#include "skein/core/pack.hpp"

namespace skein {

/// One node and its element. Before the solution it holds the block, of which the lower triangle counts, and the right
/// side. next[i][j] is the coupling to the next block, with row i there and column j here. After it the block holds its
/// factor with inverses on the diagonal, the eliminated coupling, and the solution.
template <int W> struct BandBlock {
    static constexpr int size = 6;
    using P = Pack<W>;
    P diagonal[size][size], next[size][size], u[size];

    void clear() {
        for (int i = 0; i < size; ++i)
            for (int j = 0; j < size; ++j) diagonal[i][j] = next[i][j] = P(0.0);
    }
    /// Adds one stiffness to three places of the diagonal, from `first` on.
    void add(int first, const P& stiffness) {
        for (int i = first; i < first + 3; ++i) diagonal[i][i] += stiffness;
    }
    /// Fixes unknown i to 0, without effect on others. `before`: block before this one, null for the first.
    void hold(int i, BandBlock* before) {
        for (int j = 0; j < size; ++j) {
            diagonal[i][j] = diagonal[j][i] = P(0.0);
            next[j][i] = P(0.0);
            if (before) before->next[i][j] = P(0.0);
        }
        diagonal[i][i] = P(1.0);
        u[i] = P(0.0);
    }
};

/// Right side and solution of a node and its element.
template <int W> struct BandVector { Pack<W> u[BandBlock<W>::size]; };

template <int W> using Coupling = Pack<W>[BandBlock<W>::size][BandBlock<W>::size];

/// Coupling of the last block of a ring to another one.
template <int W> struct RingCoupling { Coupling<W> last; };

namespace detail {

/// Factorises a block; its right side becomes G^-1 b.
template <int W> void factorise(BandBlock<W>& b) {
    using P = Pack<W>;
    auto& g = b.diagonal;
    for (int j = 0; j < b.size; ++j) {
        for (int m = 0; m < j; ++m) g[j][j] = fnma(g[j][m], g[j][m], g[j][j]);
        const P inverse = P(1.0) / sqrt(g[j][j]);
        g[j][j] = inverse; // 1/G
        for (int i = j + 1; i < b.size; ++i) {
            for (int m = 0; m < j; ++m) g[i][j] = fnma(g[i][m], g[j][m], g[i][j]);
            g[i][j] = inverse * g[i][j];
        }
    }
    for (int i = 0; i < b.size; ++i) {
        for (int m = 0; m < i; ++m) b.u[i] = fnma(g[i][m], b.u[m], b.u[i]);
        b.u[i] = g[i][i] * b.u[i];
    }
}

/// Eliminates the factorised block b from another one. Rows of `coupling` belong to the other block.
template <int W> void eliminate(const BandBlock<W>& b, Coupling<W>& coupling, BandBlock<W>& after) {
    const auto& g = b.diagonal;
    for (int i = 0; i < b.size; ++i) {
        for (int j = 0; j < b.size; ++j) {
            for (int m = 0; m < j; ++m) coupling[i][j] = fnma(coupling[i][m], g[j][m], coupling[i][j]);
            coupling[i][j] = g[j][j] * coupling[i][j];
        }
        for (int m = 0; m < b.size; ++m) after.u[i] = fnma(coupling[i][m], b.u[m], after.u[i]);
        for (int j = 0; j <= i; ++j)
            for (int m = 0; m < b.size; ++m)
                after.diagonal[i][j] = fnma(coupling[i][m], coupling[j][m], after.diagonal[i][j]);
    }
}

/// Subtracts the solution of another block from the right side of b.
template <int W> void substitute(BandBlock<W>& b, const Coupling<W>& coupling, const BandBlock<W>& other) {
    for (int i = 0; i < b.size; ++i)
        for (int m = 0; m < b.size; ++m) b.u[i] = fnma(coupling[m][i], other.u[m], b.u[i]);
}

/// Solution of b from G^-1 of its remaining right side.
template <int W> void solve_back(BandBlock<W>& b) {
    for (int i = b.size - 1; i >= 0; --i) {
        for (int m = i + 1; m < b.size; ++m) b.u[i] = fnma(b.diagonal[m][i], b.u[m], b.u[i]);
        b.u[i] = b.diagonal[i][i] * b.u[i];
    }
}

/// Forward and backward substitution of a factorised block.
template <int W> void substitute_forth(const BandBlock<W>& b, BandVector<W>& x) {
    for (int i = 0; i < b.size; ++i) {
        for (int m = 0; m < i; ++m) x.u[i] = fnma(b.diagonal[i][m], x.u[m], x.u[i]);
        x.u[i] = b.diagonal[i][i] * x.u[i];
    }
}
template <int W> void substitute_back(const BandBlock<W>& b, BandVector<W>& x) {
    for (int i = b.size - 1; i >= 0; --i) {
        for (int m = i + 1; m < b.size; ++m) x.u[i] = fnma(b.diagonal[m][i], x.u[m], x.u[i]);
        x.u[i] = b.diagonal[i][i] * x.u[i];
    }
}
template <int W> void take_forth(const Coupling<W>& coupling, const BandVector<W>& from, BandVector<W>& to) {
    for (int i = 0; i < BandBlock<W>::size; ++i)
        for (int m = 0; m < BandBlock<W>::size; ++m) to.u[i] = fnma(coupling[i][m], from.u[m], to.u[i]);
}
template <int W> void take_back(const Coupling<W>& coupling, const BandVector<W>& from, BandVector<W>& to) {
    for (int i = 0; i < BandBlock<W>::size; ++i)
        for (int m = 0; m < BandBlock<W>::size; ++m) to.u[i] = fnma(coupling[m][i], from.u[m], to.u[i]);
}

} // namespace detail

/// Solution of one more right side by blocks that solve_band or solve_ring has factorised. `ring`: null of a band.
template <int W> void solve_again(int last, const BandBlock<W>* block, const RingCoupling<W>* ring, BandVector<W>* x) {
    for (int k = 0; k < last; ++k) {
        detail::substitute_forth(block[k], x[k]);
        detail::take_forth<W>(block[k].next, x[k], x[k + 1]);
        if (ring && k + 1 < last) detail::take_forth<W>(ring[k].last, x[k], x[last]);
    }
    detail::substitute_forth(block[last], x[last]);
    detail::substitute_back(block[last], x[last]);
    for (int k = last - 1; k >= 0; --k) {
        detail::take_back<W>(block[k].next, x[k + 1], x[k]);
        if (ring && k + 1 < last) detail::take_back<W>(ring[k].last, x[last], x[k]);
        detail::substitute_back(block[k], x[k]);
    }
}

/// Solves for blocks 0 to `last`, without a coupling after the last. The solution is NaN where the matrix is not
/// positive.
template <int W> void solve_band(int last, BandBlock<W>* block) {
    for (int k = 0; k <= last; ++k) {
        detail::factorise(block[k]);
        if (k < last) detail::eliminate(block[k], block[k].next, block[k + 1]);
    }
    for (int k = last; k >= 0; --k) {
        if (k < last) detail::substitute(block[k], block[k].next, block[k + 1]);
        detail::solve_back(block[k]);
    }
}

/// Solves a ring of at least three blocks: the coupling of the last is to the first. `ring`: [last], memory for the
/// coupling of the last block.
template <int W> void solve_ring(int last, BandBlock<W>* block, RingCoupling<W>* ring) {
    for (int i = 0; i < BandBlock<W>::size; ++i)
        for (int j = 0; j < BandBlock<W>::size; ++j) ring[0].last[j][i] = block[last].next[i][j];
    for (int k = 0; k < last; ++k) {
        BandBlock<W>& b = block[k];
        detail::factorise(b);
        if (k + 1 == last) { // the last block is the next one
            for (int i = 0; i < b.size; ++i)
                for (int j = 0; j < b.size; ++j) b.next[i][j] += ring[k].last[i][j];
            detail::eliminate(b, b.next, block[last]);
            break;
        }
        detail::eliminate(b, b.next, block[k + 1]);
        detail::eliminate(b, ring[k].last, block[last]);
        for (int i = 0; i < b.size; ++i)
            for (int j = 0; j < b.size; ++j) {
                Pack<W> sum = ring[k].last[i][0] * b.next[j][0];
                for (int m = 1; m < b.size; ++m) sum = fma(ring[k].last[i][m], b.next[j][m], sum);
                ring[k + 1].last[i][j] = -sum;
            }
    }
    detail::factorise(block[last]);
    detail::solve_back(block[last]);
    for (int k = last - 1; k >= 0; --k) {
        detail::substitute(block[k], block[k].next, block[k + 1]);
        if (k + 1 < last) detail::substitute(block[k], ring[k].last, block[last]);
        detail::solve_back(block[k]);
    }
}

} // namespace skein
