// Rows of clusters against dense solutions.
#include "implicit/cluster_rows.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace skein {
namespace {

using P = Pack<1>;
using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

/// A system with these couplings, beside a dense one.
void expect_solution(std::size_t rows, const Pairs& coupled) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-1, 1);
    const auto order = std::make_shared<Elimination>(rows, coupled);
    const auto n = static_cast<Eigen::Index>(row_size * rows);
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b(n);
    ClusterRows<1> system;
    system.begin(order);
    const auto fill = [&](std::size_t row, std::size_t column) {
        for (std::size_t i = 0; i < row_size; ++i)
            for (std::size_t j = 0; j < row_size; ++j) {
                const double x = any(random) + (row == column && i == j ? 40 : 0);
                system.at(row, column)[i][j] += P(x);
                a(static_cast<Eigen::Index>(row_size * row + i), static_cast<Eigen::Index>(row_size * column + j)) += x;
            }
    };
    for (std::size_t row = 0; row < rows; ++row) {
        fill(row, row);
        for (std::size_t i = 0; i < row_size; ++i) {
            const double x = any(random);
            system.right(row)[i] = P(x);
            b(static_cast<Eigen::Index>(row_size * row + i)) = x;
        }
    }
    for (const auto& [i, j] : coupled) {
        fill(i, j);
        fill(j, i);
    }
    system.solve();
    const Eigen::VectorXd expected = a.partialPivLu().solve(b);
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t i = 0; i < row_size; ++i)
            EXPECT_NEAR(system.solution(row).u[i][0], expected(static_cast<Eigen::Index>(row_size * row + i)), 1e-13);
}

Pairs chain(std::size_t first, std::size_t rows) {
    Pairs pairs;
    for (std::size_t k = 1; k < rows; ++k) pairs.emplace_back(first + k - 1, first + k);
    return pairs;
}

TEST(ClusterRows, SolveRowsAlone) { expect_solution(3, {}); }

TEST(ClusterRows, SolveTreesWithFewNewBlocks) {
    Pairs star = chain(0, 5);
    for (const std::size_t first : {5, 9}) {
        const Pairs branch = chain(first, 4);
        star.insert(star.end(), branch.begin(), branch.end());
        star.emplace_back(2, first);
    }
    expect_solution(13, star);
    EXPECT_LE(Elimination(13, star).blocks(), star.size() + 1);
}

TEST(ClusterRows, SolveNetsAndRings) {
    Pairs net;
    constexpr std::size_t side = 5;
    for (std::size_t i = 0; i < side; ++i)
        for (std::size_t j = 0; j < side; ++j) {
            if (i > 0) net.emplace_back(side * i + j, side * (i - 1) + j);
            if (j > 0) net.emplace_back(side * i + j - 1, side * i + j);
        }
    net.emplace_back(0, side * side - 1);
    net.emplace_back(side * side - 1, 0); // a pair may come twice
    expect_solution(side * side, net);
    Pairs ring = chain(0, 7);
    ring.emplace_back(0, 6);
    expect_solution(7, ring);
}

} // namespace
} // namespace skein
