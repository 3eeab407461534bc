// The matrix kept by its envelope: its solution solves it, and entries outside need no room.
#include "relaxation/envelope_matrix.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace skein {
namespace {

/// A symmetric matrix with dominant diagonal. Row i has one more entry on its left, in column first[i].
std::vector<std::vector<double>> positive_matrix(const std::vector<std::size_t>& first, std::mt19937& random) {
    const std::size_t n = first.size();
    std::vector<std::vector<double>> a(n, std::vector<double>(n, 0.0));
    for (std::size_t i = 0; i < n; ++i) a[i][i] = 1;
    for (std::size_t i = 0; i < n; ++i) {
        if (first[i] == i) continue;
        const double entry = std::uniform_real_distribution<double>(-1, 1)(random);
        a[i][first[i]] = a[first[i]][i] = entry;
        for (const std::size_t j : {i, first[i]}) a[j][j] += std::abs(entry);
    }
    return a;
}

TEST(EnvelopeMatrix, SolvesWhatItHolds) {
    std::mt19937 random(7);
    for (const std::size_t n : {1, 2, 7, 40}) {
        std::vector<std::size_t> first(n);
        for (std::size_t i = 0; i < n; ++i) first[i] = std::uniform_int_distribution<std::size_t>(0, i)(random);
        const auto a = positive_matrix(first, random);
        EnvelopeMatrix matrix;
        for (std::size_t i = 0; i < n; ++i) {
            double* const row = matrix.add_row(first[i]);
            for (std::size_t j = first[i]; j <= i; ++j) row[j] = a[i][j];
        }
        std::vector<double> x(n), b(n, 0.0);
        for (double& one : x) one = std::uniform_real_distribution<double>(-1, 1)(random);
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < n; ++j) b[i] += a[i][j] * x[j];
        matrix.solve(b);
        for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(b[i], x[i], 1e-12) << n << " " << i;
    }
}

TEST(EnvelopeMatrix, HoldsNoMoreThanItsEnvelope) {
    EnvelopeMatrix matrix;
    constexpr std::size_t n = 200000, band = 3; // all entries would take 160 GB
    std::vector<double> b(n, 1.0);
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t first = i < band ? 0 : i - band;
        double* const row = matrix.add_row(first);
        for (std::size_t j = first; j < i; ++j) row[j] = -0.1;
        row[i] = 1;
    }
    matrix.solve(b);
    EXPECT_NEAR(b[n / 2], 1 / (1 - 2 * band * 0.1), 1e-12) << "far from both ends";
}

} // namespace
} // namespace skein
