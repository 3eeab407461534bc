#include "implicit/elimination.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <algorithm>
#include <set>

namespace skein {

namespace {

/// Pivot of each row in the order of least degree, which adds few blocks to chains and trees.
std::vector<std::size_t> pivots(std::size_t rows, std::span<const std::pair<std::size_t, std::size_t>> coupled) {
    using Matrix = Eigen::SparseMatrix<double>;
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](std::size_t i, std::size_t j) {
        entries.emplace_back(static_cast<int>(i), static_cast<int>(j), 1.0);
    };
    for (std::size_t row = 0; row < rows; ++row) add(row, row);
    for (const auto& [i, j] : coupled) {
        add(i, j);
        add(j, i);
    }
    Matrix matrix(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(rows));
    matrix.setFromTriplets(entries.begin(), entries.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::AMDOrdering<int>()(matrix, order);
    std::vector<std::size_t> pivot(rows);
    for (std::size_t p = 0; p < rows; ++p)
        pivot[static_cast<std::size_t>(order.indices()[static_cast<Eigen::Index>(p)])] = p;
    return pivot;
}

} // namespace

Elimination::Elimination(std::size_t rows, std::span<const std::pair<std::size_t, std::size_t>> coupled)
    : pivot_(pivots(rows, coupled)), begin_{0}, first_update_{0} {
    std::vector<std::set<std::size_t>> later(rows);
    for (const auto& [i, j] : coupled) later[std::min(pivot_[i], pivot_[j])].insert(std::max(pivot_[i], pivot_[j]));
    for (std::size_t p = 0; p < rows; ++p) {
        later_.insert(later_.end(), later[p].begin(), later[p].end());
        begin_.push_back(later_.size());
        if (!later[p].empty()) { // all that follow it are coupled once it is eliminated
            const std::size_t next = *later[p].begin();
            later[next].insert(std::next(later[p].begin()), later[p].end());
        }
    }
    for (std::size_t p = 0; p < rows; ++p) {
        const auto following = this->later(p);
        for (std::size_t i = 0; i < following.size(); ++i)
            for (std::size_t j = i + 1; j < following.size(); ++j)
                updated_.push_back(block(following[i], following[j]));
        first_update_.push_back(updated_.size());
    }
}

std::size_t Elimination::block(std::size_t first, std::size_t second) const {
    const auto from = later_.begin() + static_cast<std::ptrdiff_t>(begin_[first]),
               to = later_.begin() + static_cast<std::ptrdiff_t>(begin_[first + 1]);
    return static_cast<std::size_t>(std::lower_bound(from, to, second) - later_.begin());
}

} // namespace skein
