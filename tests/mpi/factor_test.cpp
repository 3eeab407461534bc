// Factors over ranks: every rank has the whole solution, the same bits as the others, and the signs of one rank.
#include "equilibrium/large_factor.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <random>

namespace skein {
namespace {

/// Positive and negative on its diagonal, in turn, with a few couplings far off it.
Stiffness matrix_of(int count, bool symmetric) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> some(-1, 1);
    std::uniform_int_distribution<int> any(0, count - 1);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(count, count);
    for (int i = 0; i < 4 * count; ++i) {
        const int a = any(random), b = any(random);
        dense(a, b) = some(random);
        dense(b, a) = symmetric ? dense(a, b) : some(random);
    }
    for (int i = 0; i < count; ++i) dense(i, i) = i % 3 == 0 ? -20 : 20;
    return dense.sparseView();
}

TEST(FactorOverRanks, SolvesAsOneRankDoes) {
    const Communicator comm = Communicator::world();
    for (const bool symmetric : {true, false})
        for (const int count : {2, 7, 200}) { // fewer rows than ranks, too
            const Stiffness matrix = matrix_of(count, symmetric);
            const Unknown right = Unknown::LinSpaced(count, -1, 2);
            const auto together = make_large_factor(symmetric, &comm), alone = make_large_factor(symmetric);
            ASSERT_TRUE(together && alone);
            ASSERT_TRUE(together->factorise(matrix) && alone->factorise(matrix));
            const Unknown x = together->solve(right), y = alone->solve(right);
            EXPECT_LT((x - y).norm(), 1e-13 * y.norm());
            EXPECT_LT((matrix * x - right).norm(), 1e-13 * right.norm());
            EXPECT_EQ(together->negative(), alone->negative());
            EXPECT_EQ(together->negative(), symmetric ? (count + 2) / 3 : -1);
            std::vector<double> of_root(x.data(), x.data() + count);
            comm.broadcast(std::as_writable_bytes(std::span(of_root)));
            EXPECT_TRUE(std::equal(of_root.begin(), of_root.end(), x.data()));
        }
}

TEST(FactorOverRanks, OneFactorTakesMatricesOfTheSamePatternAndOfOthers) {
    const Communicator comm = Communicator::world();
    for (const bool symmetric : {true, false}) {
        const auto factor = make_large_factor(symmetric, &comm);
        ASSERT_TRUE(factor);
        const Stiffness first = matrix_of(200, symmetric);
        Stiffness other = first; // of the same pattern, with its large entries elsewhere
        other.diagonal().array() *= -1;
        for (Eigen::Index i = 0; i < other.nonZeros(); ++i) other.valuePtr()[i] *= 1 + i % 2;
        if (symmetric) other = Stiffness((other + Stiffness(other.transpose())) / 2);
        for (int i = 0; i < 200; i += 5) other.coeffRef(i, i) = 1e-9;
        const Stiffness smaller = matrix_of(150, symmetric);
        const Stiffness* const matrices[] = {&first, &other, &first, &smaller, &first};
        for (const Stiffness* matrix : matrices) {
            const Unknown right = Unknown::LinSpaced(matrix->rows(), -1, 2);
            ASSERT_TRUE(factor->factorise(*matrix));
            const Unknown x = factor->solve(right);
            EXPECT_LT((*matrix * x - right).norm(), 1e-11 * matrix->norm() * x.norm());
            if (!symmetric) continue;
            const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> dense(Eigen::MatrixXd(*matrix),
                                                                       Eigen::EigenvaluesOnly);
            EXPECT_EQ(factor->negative(), (dense.eigenvalues().array() < 0).count());
        }
    }
}

TEST(FactorOverRanks, SingularMatricesAreFoundByAll) {
    const Communicator comm = Communicator::world();
    Eigen::MatrixXd dense(matrix_of(60, true));
    dense.row(8).setZero();
    dense.col(8).setZero();
    const Stiffness singular = dense.sparseView();
    EXPECT_FALSE(make_large_factor(true, &comm)->factorise(singular));
}

} // namespace
} // namespace skein
