#include "core/binned_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace skein {
namespace {

/// Numbers over thirty powers of ten, of both signs.
std::vector<double> terms_up_to(double largest, std::size_t count) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> power(-30, 0), sign(-1, 1);
    std::vector<double> terms(count);
    for (double& term : terms) term = std::copysign(largest * std::pow(10.0, power(random)), sign(random));
    return terms;
}

template <int W> BinnedTotal total_of(const std::vector<double>& terms, const SumBins& bins, std::size_t at_once) {
    BinnedTotal total(bins);
    for (std::size_t begin = 0; begin < terms.size(); begin += at_once) {
        const std::size_t end = std::min(terms.size(), begin + at_once);
        BinnedSum<Pack<W>> sum;
        for (std::size_t i = begin; i < end; i += W) {
            Pack<W> pack(0.0);
            for (int l = 0; l < W && i + static_cast<std::size_t>(l) < end; ++l)
                pack.set(l, terms[i + static_cast<std::size_t>(l)]);
            sum.add(pack, bins);
        }
        BinnedSum<double> block;
        for (int part = 0; part < SumBins::count; ++part)
            for (int l = 0; l < W; ++l) block.part[part] += sum.part[part][l];
        total.add(block);
    }
    return total;
}

TEST(BinnedSum, DoesNotDependOnOrderGroupingOrLanes) {
    const SumBins bins(3.0);
    std::vector<double> terms = terms_up_to(3.0, 3000);
    const BinnedTotal expected = total_of<1>(terms, bins, 3000);
    std::mt19937_64 random(1);
    for (const std::size_t at_once : {1u, 7u, 64u, 999u, 3000u}) {
        std::shuffle(terms.begin(), terms.end(), random);
        EXPECT_EQ(total_of<1>(terms, bins, at_once), expected);
        EXPECT_EQ(total_of<8>(terms, bins, at_once), expected);
        BinnedTotal halves = total_of<8>({terms.begin(), terms.begin() + 1200}, bins, at_once);
        halves.add(total_of<8>({terms.begin() + 1200, terms.end()}, bins, at_once));
        EXPECT_EQ(halves, expected);
        EXPECT_EQ(halves.value(), expected.value());
    }
}

TEST(BinnedSum, RoundsATermByHalfOfTheLastUnitAtMost) {
    const SumBins bins(3.0);
    const std::vector<double> terms = terms_up_to(3.0, 3000);
    long double sum = 0, size = 0;
    for (const double term : terms) {
        sum += term;
        size += std::abs(term);
    }
    const double error = 0.5 * 3000 * bins.unit(SumBins::count - 1) + 1e-17 * static_cast<double>(size);
    EXPECT_LT(error, 1e-13);
    EXPECT_NEAR(total_of<8>(terms, bins, 64).value(), static_cast<double>(sum), error);
    BinnedTotal cancels(bins);
    for (const double term : {1.0, 1e-25, -1.0}) cancels.add(term, bins);
    EXPECT_NEAR(cancels.value(), 1e-25, 0.5 * bins.unit(SumBins::count - 1));
}

TEST(BinnedSum, GoesOnFromItsNumbers) {
    const SumBins bins(2e-9);
    const std::vector<double> terms = terms_up_to(2e-9, 1000);
    BinnedTotal whole = total_of<8>(terms, bins, 64), resumed = BinnedTotal(bins).of(whole.numbers());
    EXPECT_EQ(resumed, whole);
    for (int i = 0; i < 20000; ++i) {
        whole.add(1.9e-9, bins);
        resumed.add(1.9e-9, bins);
    }
    EXPECT_EQ(resumed, whole);
    EXPECT_NEAR(whole.value(), 20000 * 1.9e-9, 1e-6 * 1.9e-9 + 3000 * 2e-9);
    EXPECT_EQ(BinnedTotal(bins).of(whole.numbers()), whole);
}

TEST(BinnedSum, ScalesWithItsTerms) {
    const double scale = std::ldexp(1.0, -72);
    const std::vector<double> terms = terms_up_to(3.0, 1000);
    std::vector<double> scaled = terms;
    for (double& term : scaled) term *= scale;
    EXPECT_EQ(total_of<8>(scaled, SumBins(3.0 * scale), 64).value(),
              scale * total_of<8>(terms, SumBins(3.0), 64).value());
}

TEST(BinnedSum, PassesOnWhatIsNotFinite) {
    const SumBins bins(1.0);
    BinnedTotal infinite(bins), large(bins);
    infinite.add(std::numeric_limits<double>::infinity(), bins);
    EXPECT_FALSE(std::isfinite(infinite.value()));
    EXPECT_FALSE(std::isfinite(BinnedTotal(bins).of(infinite.numbers()).value()));
    large.add(1e30, bins);
    EXPECT_NEAR(large.value(), 1e30, 1e15);
    EXPECT_EQ(SumBins(0).unit(0), SumBins(1).unit(0));
}

} // namespace
} // namespace skein
