#include "parallel/exact_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

namespace skein {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct ExactSums : testing::Test {
    const Communicator comm = Communicator::world();

    /// The sum when term i is held by rank owner(i).
    template <class Owner> double sum(const std::vector<double>& terms, Owner owner) const {
        std::vector<std::vector<double>> columns(1);
        for (std::size_t i = 0; i < terms.size(); ++i)
            if (owner(i) % comm.size() == comm.rank()) columns[0].push_back(terms[i]);
        return exact_sums(comm, columns)[0];
    }
    double on_one_rank(const std::vector<double>& terms) const {
        return sum(terms, [](std::size_t) { return 0; });
    }
};

TEST_F(ExactSums, have_the_same_bits_for_every_distribution_and_order) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> mantissa(-1, 1);
    std::uniform_int_distribution<int> exponent(-40, 40);
    std::vector<double> terms(2000);
    for (double& x : terms) x = std::ldexp(mantissa(random), exponent(random));
    const auto expected = std::bit_cast<std::uint64_t>(on_one_rank(terms));

    for (int round = 0; round < 20; ++round) {
        std::shuffle(terms.begin(), terms.end(), random);
        const auto shift = random();
        EXPECT_EQ(std::bit_cast<std::uint64_t>(sum(terms, [](std::size_t i) { return static_cast<int>(i % 97); })),
                  expected);
        EXPECT_EQ(std::bit_cast<std::uint64_t>(
                      sum(terms, [&](std::size_t i) { return static_cast<int>((i * i + shift) % 7); })),
                  expected);
        EXPECT_EQ(std::bit_cast<std::uint64_t>(sum(terms, [](std::size_t i) { return i < 1500 ? 1 : 3; })), expected);
    }
}

TEST_F(ExactSums, cancel_where_plain_sums_lose_everything) {
    EXPECT_EQ(on_one_rank({1e17, 1.0, -1e17}), 1.0);
    std::vector<double> terms;
    for (int i = 1; i <= 1000; ++i) terms.insert(terms.end(), {1.0 / i, 1e9 * i, -1e9 * i});
    long double harmonic = 0;
    for (int i = 1000; i >= 1; --i) harmonic += 1.0 / i;
    EXPECT_NEAR(on_one_rank(terms), static_cast<double>(harmonic), 1000 * std::ldexp(1e12, -86));
}

TEST_F(ExactSums, hold_at_the_ends_of_the_range) {
    const double largest = std::numeric_limits<double>::max(), smallest = std::numeric_limits<double>::denorm_min();
    const auto dealt = [](std::size_t i) { return static_cast<int>(i); };
    EXPECT_EQ(sum({}, dealt), 0.0);
    EXPECT_EQ(sum({0.0, -0.0}, dealt), 0.0);
    EXPECT_EQ(sum({largest, -largest, std::ldexp(3, 970)}, dealt), std::ldexp(3, 970));
    EXPECT_EQ(sum({largest, largest}, dealt), infinity);
    EXPECT_EQ(sum({smallest, smallest, smallest}, dealt), 3 * smallest);
    EXPECT_EQ(sum({-1.5, -2.25}, dealt), -3.75);
}

TEST_F(ExactSums, pass_on_what_is_not_finite) {
    const auto dealt = [](std::size_t i) { return static_cast<int>(i); };
    EXPECT_EQ(sum({1.0, infinity, 2.0}, dealt), infinity);
    EXPECT_EQ(sum({1.0, -infinity}, dealt), -infinity);
    EXPECT_TRUE(std::isnan(sum({1.0, infinity, -infinity}, dealt)));
    EXPECT_TRUE(std::isnan(sum({nan, infinity}, dealt)));
    EXPECT_TRUE(std::isnan(sum({1.0, 2.0, 3.0, nan}, dealt)));
}

TEST_F(ExactSums, keep_columns_apart) {
    const double mine = 1 + comm.rank();
    const std::vector<std::vector<double>> columns{{mine, mine}, {}, {1e-300 * mine}, {comm.root() ? nan : 1.0}};
    const auto sums = exact_sums(comm, columns);
    const double all = 0.5 * comm.size() * (comm.size() + 1);
    ASSERT_EQ(sums.size(), 4u);
    EXPECT_EQ(sums[0], 2 * all);
    EXPECT_EQ(sums[1], 0);
    EXPECT_NEAR(sums[2], 1e-300 * all, 1e-315);
    EXPECT_TRUE(std::isnan(sums[3]));
}

// Rows shared out to threads give the bits of columns; more rows than one thread takes at a time, over many powers of
// two.
TEST_F(ExactSums, of_a_table_are_those_of_its_columns) {
    constexpr std::size_t rows = 5000, columns = 3, stride = 5;
    std::mt19937_64 random(static_cast<unsigned>(comm.rank()));
    std::normal_distribution<double> normal;
    std::vector<double> table(rows * stride, nan);
    std::vector<std::vector<double>> twin(columns, std::vector<double>(rows));
    for (std::size_t r = 0; r < rows; ++r)
        for (std::size_t c = 0; c < columns; ++c)
            table[r * stride + c] = twin[c][r] =
                std::ldexp(normal(random), static_cast<int>(r % 97) * (static_cast<int>(c) - 1));
    for (const int threads : {1, 3})
        EXPECT_EQ(exact_sums(comm, Threads(threads), {table.data(), rows, columns, stride}), exact_sums(comm, twin));
    EXPECT_EQ(exact_sums(comm, Threads(2), {nullptr, 0, columns, stride}), std::vector<double>(columns, 0.0));

    constexpr std::size_t groups = 4; // of which one has no row
    std::vector<std::uint32_t> group(rows);
    std::vector<std::vector<double>> of_groups(groups * columns);
    for (std::size_t r = 0; r < rows; ++r) {
        group[r] = r % 7 == 0 ? 3 : static_cast<std::uint32_t>(r % 2);
        for (std::size_t c = 0; c < columns; ++c) of_groups[group[r] * columns + c].push_back(twin[c][r]);
    }
    for (const int threads : {1, 3})
        EXPECT_EQ(exact_sums(comm, Threads(threads), {table.data(), rows, columns, stride, groups, group.data()}),
                  exact_sums(comm, of_groups));
}

// Terms are rounded to whole quanta, halves to the even one, at either sign. (The quantum of a sum whose largest term
// is 1 is 2^-85.)
TEST_F(ExactSums, round_terms_to_the_nearest_even_quantum) {
    const double quantum = std::ldexp(1, -85);
    const auto rounded = [&](double quanta) {
        return sum({1.0, -1.0, quanta * quantum}, [](std::size_t) { return 0; }) / quantum;
    };
    for (const double quanta :
         {0.25, 0.5, 0.75, 1.0, 1.5, 2.5, 3.5, 1e9 + 0.5, 1e9 + 1.5, 4503599627370495.5, 9e15, 1e-40, 0x1p-900})
        for (const double sign : {1.0, -1.0})
            EXPECT_EQ(rounded(sign * quanta), std::nearbyint(sign * quanta)) << quanta;
}

} // namespace
} // namespace skein
