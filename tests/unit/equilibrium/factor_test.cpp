// Factors of every kind: solutions, and signs counted as dense eigenvalues have them, of matrices with as many negative
// eigenvalues as positive ones.
#include "equilibrium/factor.hpp"
#include "equilibrium/large_factor.hpp"
#include "equilibrium/two_level_factor.hpp"
#include "parallel/communicator.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <random>

namespace skein {
namespace {

/// Symmetric, with entries at most `band` off the diagonal and, where `far`, some anywhere.
Stiffness matrix_of(int count, int band, bool far, bool symmetric, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> some(-1, 1);
    std::uniform_int_distribution<int> any(0, count - 1);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(count, count);
    const auto put = [&](int i, int j) {
        dense(i, j) = some(random);
        dense(j, i) = symmetric ? dense(i, j) : some(random);
    };
    for (int i = 0; i < count; ++i)
        for (int j = i; j < std::min(count, i + band + 1); ++j) put(i, j);
    for (int i = 0; far && i < count / 4; ++i) put(any(random), any(random));
    for (int i = 0; i < count; ++i) dense(i, i) = (i % 2 == 0 ? 1 : -1) * (1 + std::abs(some(random))) * band;
    return dense.sparseView();
}

void expect_factor(Factor& factor, const Stiffness& matrix, bool symmetric, double error = 1e-10) {
    const Eigen::MatrixXd dense(matrix);
    ASSERT_TRUE(factor.factorise(matrix)) << factor.name();
    const Unknown right = Unknown::LinSpaced(matrix.rows(), -1, 2);
    const Unknown x = factor.solve(right);
    EXPECT_LT((dense * x - right).norm(), error * right.norm()) << factor.name();
    if (!symmetric) {
        EXPECT_EQ(factor.negative(), -1) << factor.name();
        return;
    }
    const Unknown values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense).eigenvalues();
    EXPECT_EQ(factor.negative(), (values.array() < 0).count()) << factor.name();
}

TEST(Factor, SolvesAndCountsSigns) {
    for (unsigned seed = 1; seed <= 5; ++seed)
        for (const bool symmetric : {true, false})
            for (const bool far : {false, true}) {
                const Stiffness matrix = matrix_of(150, 9, far, symmetric, seed);
                const std::unique_ptr<Factor> factor = make_factor(matrix, symmetric);
                EXPECT_TRUE(factor->suits(matrix, symmetric));
                expect_factor(*factor, matrix, symmetric);
                // The same factor takes another pattern.
                const Stiffness other = matrix_of(150, 7, far, symmetric, seed + 10);
                expect_factor(*factor, other, symmetric);
            }
}

#ifdef SKEIN_PETSC
TEST(Factor, OfLargeMatricesIsTheSame) {
    int no_words = 0;
    char** none = nullptr;
    const MpiSession session(no_words, none); // PETSc is for processes that have MPI
    for (const bool symmetric : {true, false}) {
        const std::unique_ptr<Factor> factor = make_large_factor(symmetric);
        ASSERT_TRUE(factor);
        expect_factor(*factor, matrix_of(200, 6, true, symmetric, 3), symmetric);
    }
}
#endif

TEST(Factor, KindFollowsTheBand) {
    EXPECT_EQ(make_factor(matrix_of(150, 9, false, true, 1), true)->name(), "band L D L^T");
    EXPECT_EQ(make_factor(matrix_of(150, 9, true, true, 1), true)->name(), "sparse L D L^T (Eigen)");
    EXPECT_EQ(make_factor(matrix_of(150, 9, false, false, 1), false)->name(), "sparse LU (Eigen)");
}

/// Rods of five nodes on a line, which springs hold to the ground and to each other; `pull` is taken from one spring.
Stiffness heap_of(int rods, bool symmetric, double pull) {
    const int nodes = 5, count = 3 * nodes * rods;
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(count, count);
    const auto spring = [&](int i, int j, double stiffness, double share = 1) {
        k(i, i) += stiffness;
        k(j, j) += stiffness;
        k(i, j) -= stiffness;
        k(j, i) -= share * stiffness;
    };
    std::mt19937 random(7);
    std::uniform_int_distribution<int> any(0, count / 3 - 1);
    for (int r = 0; r < rods; ++r)
        for (int n = 0; n + 1 < nodes; ++n)
            for (int i = 0; i < 3; ++i) spring(3 * (nodes * r + n) + i, 3 * (nodes * r + n + 1) + i, 1e3);
    for (int c = 0; c < 6 * rods; ++c) {
        const int a = any(random), b = any(random);
        for (int i = 0; i < 3 && a != b; ++i) spring(3 * a + i, 3 * b + i, 1, symmetric ? 1 : 0.8);
    }
    k.diagonal().array() += 0.01;
    k(4, 4) -= pull;
    return k.sparseView();
}

/// Translations and turns about the middle of each rod.
RodMotions motions_of_heap(int rods) {
    const int nodes = 5;
    RodMotions motions;
    motions.motion.setZero(3 * nodes * rods, 6);
    for (int r = 0; r <= rods; ++r) motions.first.push_back(3 * nodes * r);
    for (int n = 0; n < nodes * rods; ++n)
        for (int i = 0; i < 3; ++i) {
            motions.motion(3 * n + i, i) = 1;
            motions.motion(3 * n + i, 3 + (i + 1) % 3) = n % nodes - 2;
        }
    return motions;
}

TEST(TwoLevelFactor, SolvesAndCountsSignsByIteration) {
    for (const bool symmetric : {true, false}) {
        TwoLevelFactor factor(symmetric);
        factor.set_rods(motions_of_heap(40));
        expect_factor(factor, heap_of(40, symmetric, 0), symmetric, 1e-9);
        EXPECT_FALSE(factor.is_direct());
        EXPECT_GT(factor.iterations(), 3);
        EXPECT_LT(factor.iterations(), 100);
    }
}

TEST(TwoLevelFactor, FindsNegativeDirectionsThatRodsAndRigidMotionsHide) {
    // The pull is below what the rod and its rigid motions resist by themselves, and above what the heap does.
    const Stiffness heap = heap_of(40, true, 0);
    const Eigen::MatrixXd inverse = Eigen::MatrixXd(heap).inverse();
    for (const double pull : {0.9 / inverse(4, 4), 1.1 / inverse(4, 4), 1e4}) {
        TwoLevelFactor factor(true);
        factor.set_rods(motions_of_heap(40));
        expect_factor(factor, heap_of(40, true, pull), true, 1e-9);
        EXPECT_EQ(factor.is_direct(), pull * inverse(4, 4) > 1) << pull;
    }
}

TEST(TwoLevelFactor, StaysDirectAfterThreeFailures) {
    TwoLevelFactor factor(true);
    factor.set_rods(motions_of_heap(40));
    for (int i = 0; i < 3; ++i) expect_factor(factor, heap_of(40, true, 1e4), true);
    expect_factor(factor, heap_of(40, true, 0), true);
    EXPECT_TRUE(factor.is_direct());
}

TEST(Factor, SingularMatricesAreFound) {
    Eigen::MatrixXd dense(matrix_of(60, 5, false, true, 1));
    dense.row(8) = dense.row(7); // twice the same
    dense.col(8) = dense.col(7);
    dense(8, 8) = dense(7, 7);
    dense(7, 8) = dense(8, 7) = dense(7, 7);
    const Stiffness singular = dense.sparseView();
    EXPECT_FALSE(make_factor(singular, true)->factorise(singular));
}

} // namespace
} // namespace skein
