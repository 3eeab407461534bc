// Block systems of rods that joints couple, without symmetry: one block row per node and its element, one copy of the
// assembly a lane.                                                                                    theory.md (126)
//   pivot p   X[p][q] = D[p]^-1 A[p][q],  y[p] = D[p]^-1 b[p],   q: later pivots coupled to p
//             A[q][r] -= A[q][p] X[p][r],  b[q] -= A[q][p] y[p]
//   back      u[p] = y[p] - sum X[p][q] u[q]
// As along a rod (block_rows.hpp), no pivots are sought.
#pragma once

#include "implicit/block_rows.hpp"
#include "implicit/elimination.hpp"

#include <memory>
#include <utility>

namespace skein {

template <int W> class ClusterRows {
public:
    using P = Pack<W>;

    /// Sets all blocks and right sides to 0.
    void begin(std::shared_ptr<const Elimination> order) {
        order_ = std::move(order);
        const std::size_t rows = order_->rows(), blocks = order_->blocks();
        if (diagonal_.size() < rows) {
            diagonal_.resize(rows);
            right_.resize(rows);
        }
        if (upper_.size() < blocks) {
            upper_.resize(blocks);
            lower_.resize(blocks);
        }
        for (std::size_t p = 0; p < rows; ++p) clear<W>(diagonal_[p].a);
        for (std::size_t e = 0; e < blocks; ++e) {
            clear<W>(upper_[e].a);
            clear<W>(lower_[e].a);
        }
    }
    /// Block of two rows.
    RowBlock<W>& at(std::size_t row, std::size_t column) {
        const std::size_t i = order_->pivot(row), j = order_->pivot(column);
        return i == j ? diagonal_[i].a : i < j ? upper_[order_->block(i, j)].a : lower_[order_->block(j, i)].a;
    }
    P (&right(std::size_t row))[row_size] { return right_[order_->pivot(row)].u; }

    /// Eliminates all rows; blocks are spent.
    void solve() {
        for (std::size_t p = 0; p < order_->rows(); ++p) eliminate(p);
        for (std::size_t p = order_->rows(); p-- > 0;) {
            const auto later = order_->later(p);
            P(&u)[row_size] = right_[p].u;
            for (std::size_t q = 0; q < later.size(); ++q) {
                const P(&known)[row_size] = right_[later[q]].u;
                detail::subtract<W>(
                    upper_[order_->first_block(p) + q].a, [&](int j) -> const P& { return known[j]; }, u);
            }
        }
    }
    /// Unknowns of a row.
    RowVector<W>& solution(std::size_t row) { return right_[order_->pivot(row)]; }
    const RowVector<W>& solution(std::size_t row) const { return right_[order_->pivot(row)]; }

private:
    struct Block {
        RowBlock<W> a;
    };
    /// A block and the right side.
    using Wide = P[row_size][row_size + 1];

    void eliminate(std::size_t p) {
        const auto later = order_->later(p);
        const auto updated = order_->updated(p);
        const std::size_t first = order_->first_block(p);
        P(&y)[row_size] = right_[p].u;
        if (later.empty()) {
            P column[row_size][1];
            for (int i = 0; i < row_size; ++i) column[i][0] = y[i];
            detail::solve_block<1, W>(diagonal_[p].a, column);
            for (int i = 0; i < row_size; ++i) y[i] = column[i][0];
            return;
        }
        for (std::size_t q = 0; q < later.size(); ++q) {
            RowBlock<W> spent;
            copy(diagonal_[p].a, spent);
            if (q == 0) {
                Wide both;
                for (int i = 0; i < row_size; ++i) {
                    for (int j = 0; j < row_size; ++j) both[i][j] = upper_[first].a[i][j];
                    both[i][row_size] = y[i];
                }
                detail::solve_block<row_size + 1, W>(spent, both);
                for (int i = 0; i < row_size; ++i) {
                    for (int j = 0; j < row_size; ++j) upper_[first].a[i][j] = both[i][j];
                    y[i] = both[i][row_size];
                }
            } else detail::solve_block<row_size, W>(spent, upper_[first + q].a);
        }
        for (std::size_t i = 0, pair = 0; i < later.size(); ++i) {
            const RowBlock<W>& below = lower_[first + i].a;
            detail::subtract<W>(
                below, [&](int j) -> const P& { return y[j]; }, right_[later[i]].u);
            detail::subtract<row_size, W>(below, upper_[first + i].a, 0, diagonal_[later[i]].a);
            for (std::size_t j = i + 1; j < later.size(); ++j, ++pair) {
                detail::subtract<row_size, W>(below, upper_[first + j].a, 0, upper_[updated[pair]].a);
                detail::subtract<row_size, W>(lower_[first + j].a, upper_[first + i].a, 0, lower_[updated[pair]].a);
            }
        }
    }
    static void copy(const RowBlock<W>& from, RowBlock<W>& to) {
        for (int i = 0; i < row_size; ++i)
            for (int j = 0; j < row_size; ++j) to[i][j] = from[i][j];
    }

    std::shared_ptr<const Elimination> order_;
    AlignedVector<Block> diagonal_, upper_, lower_; ///< [pivots]; [blocks], row first; [blocks], column first
    AlignedVector<RowVector<W>> right_;             ///< [pivots]: right sides, then unknowns
};

/// Rows of a tile among those of its cluster.
template <int W> class RowsOfTile {
public:
    /// `first`: number of row 0, which the others follow; a ring closes at `last`.
    RowsOfTile(ClusterRows<W>& all, std::size_t first, int last, bool ring)
        : all_(all), first_(first), last_(last), ring_(ring) {}

    void add(int k, const BlockRow<W>& row) {
        const std::size_t own = number(k);
        add(row.diagonal, all_.at(own, own));
        if (k > 0 || ring_) add(row.before, all_.at(own, number(k > 0 ? k - 1 : last_)));
        if (k < last_ || ring_) add(row.after, all_.at(own, number(k < last_ ? k + 1 : 0)));
        for (int i = 0; i < row_size; ++i) all_.right(own)[i] = row.right[i];
    }

private:
    std::size_t number(int k) const { return first_ + to_index(k); }
    static void add(const RowBlock<W>& block, RowBlock<W>& to) {
        for (int i = 0; i < row_size; ++i)
            for (int j = 0; j < row_size; ++j) to[i][j] += block[i][j];
    }

    ClusterRows<W>& all_;
    std::size_t first_;
    int last_;
    bool ring_;
};

} // namespace skein
