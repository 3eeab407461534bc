// Operations of formulas: the same bits at all widths, and how far functions are from the truth.
#include "formula/evaluate.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

namespace skein {
namespace {

constexpr Op all_operations[] = {Op::negative,    Op::absolute,  Op::root,
                                 Op::floor,       Op::sine,      Op::cosine,
                                 Op::exponential, Op::logarithm, Op::hyperbolic_tangent,
                                 Op::add,         Op::subtract,  Op::multiply,
                                 Op::divide,      Op::power,     Op::arc_tangent,
                                 Op::least,       Op::most,      Op::less,
                                 Op::less_equal,  Op::equal,     Op::choice};

class Numbers {
public:
    /// Of all sizes, and now and then none.
    double operator()() {
        static constexpr double odd[] = {0.0,
                                         -0.0,
                                         1.0,
                                         1e300,
                                         709.5,
                                         -745.5,
                                         1e5,
                                         1.0000001e5,
                                         5e-324,
                                         -1e-310,
                                         std::numeric_limits<double>::infinity(),
                                         std::numeric_limits<double>::quiet_NaN()};
        if (random_() % 8 == 0) return odd[random_() % std::size(odd)];
        return std::ldexp(normal_(random_), static_cast<int>(random_() % 40) - 20);
    }

private:
    std::mt19937 random_{3};
    std::normal_distribution<double> normal_;
};

template <int W> void lanes_are_alone(Numbers& number) {
    for (const Op op : all_operations)
        for (int trial = 0; trial < 300; ++trial) {
            Pack<W> a, b, c, r(0.0);
            for (int l = 0; l < W; ++l) a.set(l, number()), b.set(l, trial % 7 == 0 ? a[l] : number()), c.set(l, number());
            with_operation(op, [&]<Op o>() { r = operate<o>(a, b, c); });
            for (int l = 0; l < W; ++l) {
                Pack<1> one(0.0);
                with_operation(op, [&]<Op o>() { one = operate<o>(Pack<1>(a[l]), Pack<1>(b[l]), Pack<1>(c[l])); });
                if (std::isnan(one[0]) && std::isnan(r[l])) continue;
                EXPECT_EQ(std::bit_cast<std::uint64_t>(r[l]), std::bit_cast<std::uint64_t>(one[0]))
                    << "operation " << static_cast<int>(op) << " of " << a[l] << ", " << b[l] << ", " << c[l];
            }
        }
}

TEST(Operations, GiveALaneWhatItWouldGetAlone) {
    Numbers number;
    lanes_are_alone<2>(number);
    lanes_are_alone<4>(number);
    lanes_are_alone<8>(number);
}

/// Largest distance to f in long double, in units in the last place.
template <Op op> double largest_error(long double (*f)(long double), double size, bool positive) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> share(positive ? 0 : -1, 1);
    double largest = 0;
    for (int trial = 0; trial < 200000; ++trial) {
        const double x = size * share(random) * std::ldexp(1.0, -static_cast<int>(random() % 12));
        const Pack<1> r = operate<op>(Pack<1>(x), Pack<1>(0.0), Pack<1>(0.0));
        const long double exact = f(x);
        const double ulp = std::nextafter(std::fabs(static_cast<double>(exact)), HUGE_VAL) - std::fabs(static_cast<double>(exact));
        largest = std::max(largest, static_cast<double>(std::fabs(static_cast<long double>(r[0]) - exact)) / ulp);
    }
    return largest;
}

TEST(Operations, AreNearTheTruth) {
    const auto report = [](const char* what, double error, double most) {
        EXPECT_LE(error, most) << what;
        testing::Test::RecordProperty(what, std::to_string(error));
    };
    report("sine", largest_error<Op::sine>(std::sin, 30, false), 1.5);
    report("sine_of_large", largest_error<Op::sine>(std::sin, 1e5, false), 1.5);
    report("cosine", largest_error<Op::cosine>(std::cos, 30, false), 1.5);
    report("cosine_of_large", largest_error<Op::cosine>(std::cos, 1e5, false), 1.5);
    report("exponential", largest_error<Op::exponential>(std::exp, 700, false), 2.5);
    report("logarithm", largest_error<Op::logarithm>(std::log, 1e6, true), 2);
    // Where sines vanish: multiples of pi as near as doubles come.
    for (int k = 1; k < 30000; ++k) {
        const double x = k * 3.14159265358979323846;
        const long double exact = std::sin(static_cast<long double>(x));
        EXPECT_NEAR(static_cast<double>(sin(Pack<1>(x))[0] / exact), 1, 1e-14) << k;
    }
}

} // namespace
} // namespace skein
