// Packs narrower than registers, as wide, and wider, which are made of halves: every lane does what one number does.
#include "contact/compress.hpp"
#include "contact/transposed.hpp"
#include "core/pack.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace skein {
namespace {

template <class Width> class PackOf : public testing::Test {
protected:
    static constexpr int W = Width::value;
    using P = Pack<W>;
    std::mt19937 random{7};

    /// Ordinary numbers, and now and then one that is not.
    P some() {
        static constexpr double odd[] = {
            0.0, -0.0, 1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(), 5e-324, -1e308};
        P p;
        for (int l = 0; l < W; ++l)
            p.set(l, random() % 4 == 0 ? odd[random() % std::size(odd)]
                                       : std::ldexp(std::normal_distribution()(random), int(random() % 40) - 20));
        return p;
    }
    static void expect_bits(double a, double b) {
        if (std::isnan(a) && std::isnan(b)) return;
        EXPECT_EQ(std::bit_cast<std::uint64_t>(a), std::bit_cast<std::uint64_t>(b)) << a << " against " << b;
    }
    /// f of packs against f of single lanes.
    template <class F> void each(F&& f) {
        for (int trial = 0; trial < 200; ++trial) {
            const P a = some(), b = some(), c = some();
            const P all = f(a, b, c);
            for (int l = 0; l < W; ++l) expect_bits(all[l], f(Pack<1>(a[l]), Pack<1>(b[l]), Pack<1>(c[l]))[0]);
        }
    }
};
using Widths = testing::Types<std::integral_constant<int, 1>, std::integral_constant<int, 2>, std::integral_constant<int, 4>,
                              std::integral_constant<int, 8>>;
TYPED_TEST_SUITE(PackOf, Widths);

TYPED_TEST(PackOf, DoesInEveryLaneWhatOneNumberDoes) {
    this->each([](auto a, auto b, auto) { return a + b; });
    this->each([](auto a, auto b, auto) { return a - b; });
    this->each([](auto a, auto b, auto) { return a * b; });
    this->each([](auto a, auto b, auto) { return a / b; });
    this->each([](auto a, auto, auto) { return -a; });
    this->each([](auto a, auto, auto) { return abs(a); });
    this->each([](auto a, auto, auto) { return sqrt(a); });
    this->each([](auto a, auto b, auto) { return max(a, b); });
    this->each([](auto a, auto b, auto) { return min(a, b); });
    this->each([](auto a, auto b, auto c) { return fma(a, b, c); });
    this->each([](auto a, auto b, auto c) { return fms(a, b, c); });
    this->each([](auto a, auto b, auto c) { return fnma(a, b, c); });
    this->each([](auto a, auto b, auto c) { return select(a < b, c, a); });
    this->each([](auto a, auto b, auto c) { return select((a <= b) & !(b > c), c, b); });
    this->each([](auto a, auto b, auto c) { return select((a >= b) | (b < c), a, c); });
    this->each([](auto a, auto b, auto c) { return (a += b, a -= c, a *= b); });
}

TYPED_TEST(PackOf, OneNumberIsTheLibrarys) {
    const double a = 1.1, b = 1e17, c = -1.1e17;
    EXPECT_EQ(fma(Pack<1>(a), Pack<1>(b), Pack<1>(c))[0], std::fma(a, b, c));
    EXPECT_NE(std::fma(a, b, c), a * b + c); // rounded once
}

TYPED_TEST(PackOf, PowersOfTwo) {
    constexpr int W = TypeParam::value;
    for (int k = -1022; k + W <= 1023; k += 13) {
        Pack<W> exponent;
        for (int l = 0; l < W; ++l) exponent.set(l, k + l);
        for (int l = 0; l < W; ++l) EXPECT_EQ(power_of_two(exponent)[l], std::ldexp(1.0, k + l));
    }
}

TYPED_TEST(PackOf, LanesGoRound) {
    constexpr int W = TypeParam::value;
    Pack<W> p;
    for (int l = 0; l < W; ++l) p.set(l, l);
    for (int l = 0; l < W; ++l) {
        EXPECT_EQ(from_lane_after(p)[l], (l + 1) % W);
        EXPECT_EQ(from_lane_before(p)[l], (l + W - 1) % W);
    }
}

TYPED_TEST(PackOf, MasksAsBitsAndWhatTheyChoose) {
    constexpr int W = TypeParam::value;
    for (unsigned bits = 0; bits < 1u << W; ++bits) {
        Pack<W> p, number;
        for (int l = 0; l < W; ++l) p.set(l, bits >> l & 1 ? -1 : 1), number.set(l, 10 + l);
        const Mask<W> mask = p < Pack<W>(0.0);
        EXPECT_EQ(bits_of(mask), bits);
        EXPECT_EQ(any(mask), bits != 0);
        for (int l = 0; l < W; ++l) EXPECT_EQ(mask[l], (bits >> l & 1) != 0);
        double chosen[W] = {};
        compress_store(chosen, bits, number);
        for (int l = 0, n = 0; l < W; ++l)
            if (bits >> l & 1) EXPECT_EQ(chosen[n++], 10 + l);
    }
}

TYPED_TEST(PackOf, RecordsTransposedThereAndBack) {
    constexpr int W = TypeParam::value;
    alignas(64) double record[W][8] = {}, copy[W][8] = {};
    for (int l = 0; l < W; ++l)
        for (int n = 0; n < 8; ++n) record[l][n] = 10 * l + n;
    const auto loaded = load_transposed<W>([&](int l) { return static_cast<const double*>(record[l]); });
    for (int l = 0; l < W; ++l) {
        EXPECT_EQ(loaded.vector.x[l], 10 * l);
        EXPECT_EQ(loaded.vector.y[l], 10 * l + 1);
        EXPECT_EQ(loaded.vector.z[l], 10 * l + 2);
        EXPECT_EQ(loaded.behind[l], 10 * l + 3);
    }
    store_transposed<W>(loaded.vector, loaded.behind, [&](int l) { return copy[l]; });
    for (int l = 0; l < W; ++l)
        for (int n = 0; n < 8; ++n) EXPECT_EQ(copy[l][n], n < 4 ? record[l][n] : 0);
}

} // namespace
} // namespace skein
