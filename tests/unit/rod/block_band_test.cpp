// The band of blocks: its solution solves it, in every lane, and what is held stays.
#include "relaxation/block_band.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace skein {
namespace {

constexpr int size = BandBlock<1>::size;

/// A full matrix and its right side, [unknowns][unknowns] and [unknowns].
struct Dense {
    explicit Dense(int blocks) : n(static_cast<std::size_t>(blocks * size)), a(n * n, 0.0), b(n, 0.0) {}
    double& at(std::size_t i, std::size_t j) { return a[i * n + j]; }
    std::size_t n;
    std::vector<double> a, b;
};

/// Along a rod, or round a ring: whether blocks are next to each other.
bool joined(std::size_t one, std::size_t other, int blocks, bool ring) {
    const std::size_t apart = std::max(one, other) - std::min(one, other);
    return apart <= 1 || (ring && apart == static_cast<std::size_t>(blocks - 1));
}

/// Symmetric, and positive as its diagonal outweighs each row; some rows are a million times as stiff as others.
Dense random_system(int blocks, unsigned seed, bool ring) {
    Dense dense(blocks);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    std::vector<double> scale(dense.n);
    for (double& s : scale) s = std::pow(10, 3 * any(random));
    for (std::size_t i = 0; i < dense.n; ++i) {
        for (std::size_t j = 0; j < i; ++j)
            if (joined(i / size, j / size, blocks, ring))
                dense.at(i, j) = dense.at(j, i) = scale[i] * scale[j] * any(random);
        dense.at(i, i) = scale[i] * scale[i] * (3 * size + any(random));
        dense.b[i] = scale[i] * any(random);
    }
    return dense;
}

template <int W> void set_blocks(int l, Dense& dense, std::vector<BandBlock<W>>& block, bool ring) {
    const auto last = static_cast<int>(block.size()) - 1;
    for (int k = 0; k <= last; ++k)
        for (int i = 0; i < size; ++i) {
            const auto row = static_cast<std::size_t>(k * size + i);
            for (int j = 0; j < size; ++j) {
                const auto column = static_cast<std::size_t>(k * size + j);
                BandBlock<W>& b = nth(block, k);
                b.diagonal[i][j].set(l, j <= i ? dense.at(row, column)
                                               : std::nan("")); // the upper triangle is not looked at
                b.next[i][j].set(l, k < last ? dense.at(row + size, column)
                                    : ring   ? dense.at(static_cast<std::size_t>(i), column)
                                             : std::nan(""));
            }
            nth(block, k).u[i].set(l, dense.b[row]);
        }
}

/// Largest |A u - b| of a row over the largest of its terms.
template <int W> double residual(int l, Dense& dense, const std::vector<BandBlock<W>>& block) {
    double largest = 0;
    for (std::size_t i = 0; i < dense.n; ++i) {
        double sum = -dense.b[i], term = std::abs(dense.b[i]);
        for (std::size_t j = 0; j < dense.n; ++j) {
            const double part = dense.at(i, j) * block[j / size].u[j % size][l];
            sum += part;
            term = std::max(term, std::abs(part));
        }
        largest = std::max(largest, std::abs(sum) / term);
    }
    return largest;
}

template <int W> void solve(std::vector<BandBlock<W>>& block, bool ring) {
    const auto last = static_cast<int>(block.size()) - 1;
    if (!ring) return solve_band(last, block.data());
    std::vector<RingCoupling<W>> couplings(block.size() - 1);
    solve_ring(last, block.data(), couplings.data());
}

class BlockBand : public testing::TestWithParam<bool> {};

TEST_P(BlockBand, SolutionSolvesTheFullSystemInEveryLane) {
    const bool ring = GetParam();
    for (const int blocks : {1, 2, 3, 4, 9}) {
        if (ring && blocks < 3) continue;
        std::vector<BandBlock<4>> block(static_cast<std::size_t>(blocks));
        std::vector<Dense> dense;
        for (int l = 0; l < 4; ++l)
            set_blocks(l, dense.emplace_back(random_system(blocks, static_cast<unsigned>(10 * blocks + l), ring)),
                       block, ring);
        solve(block, ring);
        for (int l = 0; l < 4; ++l) {
            EXPECT_LT(residual(l, nth(dense, l), block), 1e-14) << blocks << " blocks, lane " << l;
            std::vector<BandBlock<1>> alone(block.size());
            set_blocks(0, nth(dense, l), alone, ring);
            solve(alone, ring);
            for (std::size_t k = 0; k < block.size(); ++k)
                for (int i = 0; i < size; ++i) EXPECT_EQ(alone[k].u[i][0], block[k].u[i][l]);
        }
    }
}

TEST_P(BlockBand, WhatIsHeldStaysAndMovesNothing) {
    const bool ring = GetParam();
    constexpr int blocks = 4;
    for (int held = 0; held < blocks * size; ++held) {
        Dense dense = random_system(blocks, 7, ring);
        std::vector<BandBlock<1>> block(blocks);
        set_blocks(0, dense, block, ring);
        const auto k = static_cast<std::size_t>(held / size), row = static_cast<std::size_t>(held);
        block[k].hold(held % size, k > 0 ? &block[k - 1] : ring ? &block.back() : nullptr);
        for (std::size_t j = 0; j < dense.n; ++j) dense.at(row, j) = dense.at(j, row) = 0;
        dense.at(row, row) = 1;
        dense.b[row] = 0;
        solve(block, ring);
        EXPECT_EQ(block[k].u[held % size][0], 0);
        EXPECT_LT(residual(0, dense, block), 1e-14) << held;
    }
}

INSTANTIATE_TEST_SUITE_P(Shapes, BlockBand, testing::Bool(),
                         [](const auto& ring) { return ring.param ? "ring" : "rod"; });

} // namespace
} // namespace skein
