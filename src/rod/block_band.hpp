// Linear systems of a node and its element after the other along a rod: symmetric, positive, and each coupled to the next alone.
//   A = G G^T, block by block along the rod; G y = b on the way, G^T u = y on the way back.      One rod a lane.
// 6 unknowns a block: displacement of the node, turn of its element.
#pragma once

#include "skein/core/pack.hpp"

namespace skein {

/// One node and its element. Before solve_band: the block, of which the lower triangle counts; the coupling to the next one,
/// next[i][j] of row i there and column j here; right sides. After it: the block's factor with inverses on the diagonal, what the
/// factor makes of the coupling, and the solution.
template <int W> struct BandBlock {
    static constexpr int size = 6;
    using P = Pack<W>;
    P diagonal[size][size], next[size][size], u[size];

    void clear() {
        for (int i = 0; i < size; ++i)
            for (int j = 0; j < size; ++j) diagonal[i][j] = next[i][j] = P(0.0);
    }
    /// The same onto three places of the diagonal, from `first` on.
    void add(int first, const P& stiffness) {
        for (int i = first; i < first + 3; ++i) diagonal[i][i] += stiffness;
    }
    /// Solution 0 for unknown i, which moves no other one; `before`: of the block before this one, null of the first.
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

namespace detail {

/// Becomes its factor, and its right side G^-1 b.
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

/// Takes block b, factorised, out of the one after it, to which `coupling` joins it.
template <int W> void eliminate(const BandBlock<W>& b, Pack<W> (&coupling)[6][6], BandBlock<W>& after) {
    const auto& g = b.diagonal;
    for (int i = 0; i < b.size; ++i) {
        for (int j = 0; j < b.size; ++j) {
            for (int m = 0; m < j; ++m) coupling[i][j] = fnma(coupling[i][m], g[j][m], coupling[i][j]);
            coupling[i][j] = g[j][j] * coupling[i][j];
        }
        for (int m = 0; m < b.size; ++m) after.u[i] = fnma(coupling[i][m], b.u[m], after.u[i]);
        for (int j = 0; j <= i; ++j)
            for (int m = 0; m < b.size; ++m) after.diagonal[i][j] = fnma(coupling[i][m], coupling[j][m], after.diagonal[i][j]);
    }
}

} // namespace detail

/// Blocks 0 to `last`; the coupling of the last is not looked at. Where the matrix is not positive the solution is no number.
template <int W> void solve_band(int last, BandBlock<W>* block) {
    for (int k = 0; k <= last; ++k) {
        detail::factorise(block[k]);
        if (k < last) detail::eliminate(block[k], block[k].next, block[k + 1]);
    }
    for (int k = last; k >= 0; --k) {
        BandBlock<W>& b = block[k];
        for (int i = b.size - 1; i >= 0; --i) {
            if (k < last)
                for (int m = 0; m < b.size; ++m) b.u[i] = fnma(b.next[m][i], block[k + 1].u[m], b.u[i]);
            for (int m = i + 1; m < b.size; ++m) b.u[i] = fnma(b.diagonal[m][i], b.u[m], b.u[i]);
            b.u[i] = b.diagonal[i][i] * b.u[i];
        }
    }
}

} // namespace skein
