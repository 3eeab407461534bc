// Packs narrower than registers, as wide, and wider, which are made of halves: every lane does what one number does.
#include "contact/compress.hpp"
#include "core/logarithm.hpp"
#include "core/transposed.hpp"
#include "skein/core/pack.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

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
            0.0,    -0.0,  1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(),
            5e-324, -1e308};
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
using Widths = testing::Types<std::integral_constant<int, 1>, std::integral_constant<int, 2>,
                              std::integral_constant<int, 4>, std::integral_constant<int, 8>>;
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
        for (int l = 0; l < W; ++l) {
            p.set(l, bits >> l & 1 ? -1 : 1);
            number.set(l, 10 + l);
        }
        const Mask<W> mask = p < Pack<W>(0.0);
        EXPECT_EQ(bits_of(mask), bits);
        EXPECT_EQ(any(mask), bits != 0);
        for (int l = 0; l < W; ++l) EXPECT_EQ(mask[l], (bits >> l & 1) != 0);
        double chosen[W] = {};
        compress_store(chosen, bits, number);
        for (int l = 0, n = 0; l < W; ++l) {
            if (bits >> l & 1) {
                EXPECT_EQ(chosen[n++], 10 + l);
            }
        }
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
        EXPECT_EQ(loaded.fourth[l], 10 * l + 3);
    }
    store_transposed<W>(loaded.vector, loaded.fourth, [&](int l) { return copy[l]; });
    for (int l = 0; l < W; ++l)
        for (int n = 0; n < 8; ++n) EXPECT_EQ(copy[l][n], n < 4 ? record[l][n] : 0);
}

// x - ln(1 + x): nothing cancels for small x, and lanes beyond the series have no part in what the others are.
template <int W> void check_less_log() {
    std::vector<double> some = {0.0,    -0.0, 1e-300,  1e-9, -1e-9, 1e-4, 0.02, -0.02,
                                0.4189, 0.42, -0.2951, -0.3, -0.95, 3.0,  19.0, 1e6};
    for (int i = 0; i < 400; ++i) some.push_back(-0.6 + 0.003 * i);
    for (std::size_t at = 0; at < some.size(); ++at) {
        Pack<W> x;
        for (int i = 0; i < W; ++i) x.set(i, some[(at + 7 * static_cast<std::size_t>(i)) % some.size()]);
        const Pack<W> found = less_log(x);
        for (int i = 0; i < W; ++i) {
            const long double exact = static_cast<long double>(x[i]) - std::log1p(static_cast<long double>(x[i]));
            // Of tiny arguments long double cancels too; there the series' first term is exact.
            const long double expected =
                std::abs(x[i]) < 1e-5 ? static_cast<long double>(x[i]) * x[i] * (0.5L - x[i] / 3.0L) : exact;
            EXPECT_NEAR(found[i], static_cast<double>(expected), 1e-15 * static_cast<double>(expected)) << x[i];
            EXPECT_EQ(std::bit_cast<std::uint64_t>(found[i]), std::bit_cast<std::uint64_t>(less_log(Pack<1>(x[i]))[0]))
                << x[i];
        }
    }
    EXPECT_TRUE(std::isnan(less_log(Pack<W>(-1.5))[W - 1]));
}

// Near 1 the exponent must not spoil small results; at the ends of the mantissa's range both neighbours are right.
template <int W> void check_log() {
    std::vector<double> some = {1, 2, 0.5, 1e-300, 1e300, 2.2250738585072014e-308, 1.7976931348623157e308};
    for (const double at : {0.5, 0.70710678118654752, 1.0, 1.4142135623730951, 2.0, 1e8})
        for (const double less : {1e-16, 1e-12, 1e-6, 1e-3})
            some.insert(some.end(), {at * (1 - less), at, at * (1 + less)});
    for (int i = 1; i < 400; ++i) {
        some.push_back(0.013 * i);
        some.push_back(std::exp(1.7 * (i - 200)));
    }
    for (std::size_t at = 0; at < some.size(); ++at) {
        Pack<W> x;
        for (int i = 0; i < W; ++i) x.set(i, some[(at + 7 * static_cast<std::size_t>(i)) % some.size()]);
        const Pack<W> found = log(x);
        for (int i = 0; i < W; ++i) {
            const auto exact = static_cast<double>(std::log(static_cast<long double>(x[i])));
            EXPECT_NEAR(found[i], exact, 5e-16 * std::abs(exact)) << x[i];
            EXPECT_EQ(std::bit_cast<std::uint64_t>(found[i]), std::bit_cast<std::uint64_t>(log(Pack<1>(x[i]))[0]))
                << x[i];
        }
    }
}

TEST(Logarithm, OfAllWidths) {
    check_log<1>();
    check_log<2>();
    check_log<4>();
    check_log<8>();
    check_less_log<1>();
    check_less_log<2>();
    check_less_log<4>();
    check_less_log<8>();
}

} // namespace
} // namespace skein
