// Operations of formulas: the same bits at all widths and levels, how far functions are from the truth, and what C has
// them give of zeros, infinities and what is no number. All operations are in these tests, a new one too: it has no
// reference before it has one here.
#include "formula/evaluate.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace skein {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
constexpr double odd_numbers[] = {0.0,    -0.0,    1.0,      -1.0,      2.0,    -3.0,      0.5,    -0.5,       1e300,
                                  -1e300, 708.0,   709.5,    -709.5,    -745.5, -0x1p-540, 0x1p60, -0x1p60,    0x1p1000,
                                  1e-320, -5e-324, infinity, -infinity, none,   1e5,       0x1p30, 1.0000001e9};

template <class F> void for_each_operation(F&& f) {
    for (int i = static_cast<int>(Op::negative); i <= static_cast<int>(Op::choice); ++i)
        if (const auto op = static_cast<Op>(i); op != Op::tabulated && op != Op::tabulated_slope) f(op);
}

template <int W> Pack<W> result_of(Op op, const Pack<W>& a, const Pack<W>& b, const Pack<W>& c) {
    Pack<W> r(none);
    with_operation(op, [&]<Op o>() { r = operate<o>(a, b, c); });
    return r;
}
double result_of(Op op, double a, double b = 0, double c = 0) {
    return result_of<1>(op, Pack<1>(a), Pack<1>(b), Pack<1>(c))[0];
}

/// Numbers that no library has a part in: the same on every machine.
class Numbers {
public:
    double share() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
    /// Of sizes 2^low to 2^high, of either sign.
    double sized(int low, int high) {
        const double mantissa = 1 + share(); // by itself: arguments are worked out in any order
        const double size = std::ldexp(mantissa, low + static_cast<int>(random_() % static_cast<unsigned>(high - low)));
        return random_() % 2 == 0 ? size : -size;
    }
    double operator()() {
        const auto kind = random_() % 8;
        return kind == 0   ? odd_numbers[random_() % std::size(odd_numbers)]
               : kind == 1 ? sized(-1074, 1023)
                           : sized(-20, 20);
    }

private:
    std::mt19937_64 random_{3};
};

template <int W> void lanes_are_alone(Numbers& number) {
    for_each_operation([&](Op op) {
        for (int trial = 0; trial < 1000; ++trial) {
            Pack<W> a, b, c;
            for (int l = 0; l < W; ++l) {
                a.set(l, number());
                b.set(l, trial % 7 == 0 ? a[l] : number());
                c.set(l, number());
            }
            const Pack<W> r = result_of(op, a, b, c);
            for (int l = 0; l < W; ++l) {
                const double one = result_of(op, a[l], b[l], c[l]);
                if (std::isnan(one) && std::isnan(r[l])) continue;
                EXPECT_EQ(std::bit_cast<std::uint64_t>(r[l]), std::bit_cast<std::uint64_t>(one))
                    << "operation " << static_cast<int>(op) << " of " << a[l] << ", " << b[l] << ", " << c[l];
            }
        }
    });
}

TEST(Operations, GiveALaneWhatItWouldGetAlone) {
    Numbers number;
    lanes_are_alone<2>(number);
    lanes_are_alone<4>(number);
    lanes_are_alone<8>(number);
}

// Strips take a shorter way where all numbers allow it.
TEST(Operations, HaveTheSameBitsInStrips) {
    constexpr int W = 4, places = 20;
    for_each_operation([&](Op op) {
        Numbers number;
        for (int trial = 0; trial < 40; ++trial) {
            Pack<W> a[places], b[places];
            for (int i = 0; i < places; ++i)
                for (int l = 0; l < W; ++l) {
                    a[i].set(l, number.sized(-20, 9));
                    b[i].set(l, number());
                }
            if (trial % 2 == 1)
                a[trial / 2].set(trial % W, odd_numbers[static_cast<std::size_t>(trial) % std::size(odd_numbers)]);
            const InstructionList list{.code = {{op, 0, 0, 1, 2, 1}}, .registers = 1, .inputs = {0, 1}, .outputs = {0}};
            Strided<W> source[3] = {{}, {a, 1}, {b, 1}};
            StripRegisters<W> registers;
            evaluate<W>(list, {}, source, registers, places);
            for (int i = 0; i < places; ++i)
                for (int l = 0; l < W; ++l) {
                    const double alone = result_of(op, a[i][l], b[i][l], a[i][l]), found = source[0][i][l];
                    if (std::isnan(alone) && std::isnan(found)) continue;
                    EXPECT_EQ(std::bit_cast<std::uint64_t>(found), std::bit_cast<std::uint64_t>(alone))
                        << "operation " << static_cast<int>(op) << " of " << a[i][l] << " and " << b[i][l];
                }
        }
    });
}

// This file is compiled for every level, with fused multiply-adds of the processor and without.
TEST(Operations, HaveTheSameBitsAtEveryLevel) {
    std::uint64_t hash = 0;
    Numbers number;
    for_each_operation([&](Op op) {
        for (int trial = 0; trial < 20000; ++trial) {
            const double a = number(), b = number(), r = result_of(op, a, b, number());
            hash = std::rotl(hash ^ (std::isnan(r) ? 1 : std::bit_cast<std::uint64_t>(r)), 29) * 0x9e3779b97f4a7c15;
        }
    });
    EXPECT_EQ(hash, 14919727002973832622u);
}

/// C's, with 64 bits.
long double reference(Op op, long double a, long double b, long double c) {
    switch (op) {
    case Op::negative:
        return -a;
    case Op::absolute:
        return std::fabs(a);
    case Op::root:
        return std::sqrt(a);
    case Op::floor:
        return std::floor(a);
    case Op::sine:
        return std::sin(a);
    case Op::cosine:
        return std::cos(a);
    case Op::exponential:
        return std::exp(a);
    case Op::logarithm:
        return std::log(a);
    case Op::hyperbolic_tangent:
        return std::tanh(a);
    case Op::add:
        return a + b;
    case Op::subtract:
        return a - b;
    case Op::multiply:
        return a * b;
    case Op::divide:
        return a / b;
    case Op::power:
        return std::pow(a, b);
    case Op::arc_tangent:
        return std::atan2(a, b);
    case Op::least:
        return b < a ? b : a;
    case Op::most:
        return a < b ? b : a;
    case Op::less:
        return a < b;
    case Op::less_equal:
        return a <= b;
    case Op::equal:
        return a == b;
    case Op::choice:
        return a < 0 || a > 0 ? b : c;
    case Op::constant:
    case Op::variable:
    case Op::tabulated:
    case Op::tabulated_slope:
        break;
    }
    ADD_FAILURE() << "operation " << static_cast<int>(op) << " has no reference";
    return 0;
}
/// Most that an operation may be away from it, in units in the last place.
double most_error(Op op) {
    switch (op) {
    case Op::sine:
    case Op::cosine:
        return 1.5;
    case Op::exponential:
    case Op::hyperbolic_tangent:
    case Op::power:
        return 1.15;
    case Op::logarithm:
        return 0.9;
    case Op::arc_tangent:
        return 0.75; // with subnormal operands 1.5
    default:
        return 0.501; // rounded
    }
}

/// Distance in units in the last place of the exact value; those of the smallest numbers below normal ones.
double error_of(double found, long double exact) {
    const auto nearest = static_cast<double>(exact);
    if (std::isnan(nearest)) return std::isnan(found) ? 0 : infinity;
    if (std::isinf(nearest) || std::isinf(found)) return found == nearest ? 0 : infinity;
    const double size = std::fabs(nearest), unit = size - std::nextafter(size, 0.0);
    return static_cast<double>(std::fabs(static_cast<long double>(found) - exact)) / (size == 0 ? 5e-324 : unit);
}

struct Range {
    const char* what;
    double (*a)(Numbers&);
    double (*b)(Numbers&);
};
void check_errors(Op op, std::span<const Range> ranges, double most) {
    Numbers number;
    for (const Range& range : ranges) {
        double largest = 0, at = 0, with = 0;
        for (int trial = 0; trial < 100000; ++trial) {
            const double a = range.a(number), b = range.b(number);
            const double error = error_of(result_of(op, a, b, 1), reference(op, a, b, 1));
            if (error > largest) {
                largest = error;
                at = a;
                with = b;
            }
        }
        EXPECT_LE(largest, most) << "operation " << static_cast<int>(op) << " " << range.what << ", of " << at
                                 << " and " << with;
        testing::Test::RecordProperty(std::to_string(static_cast<int>(op)) + "_" + range.what, std::to_string(largest));
    }
}

TEST(Operations, AreNearTheTruth) {
    constexpr auto of_one = [](Numbers& n) { return 2 * n.share() - 1; };
    constexpr Range everywhere[] = {
        {"near_1", of_one, of_one},
        {"to_30", [](Numbers& n) { return 60 * n.share() - 30; }, of_one},
        {"wide", [](Numbers& n) { return n.sized(-60, 60); }, [](Numbers& n) { return n.sized(-60, 60); }},
        {"wide_to_1", [](Numbers& n) { return n.sized(-60, 60); }, of_one}};
    for_each_operation([&](Op op) { check_errors(op, everywhere, most_error(op)); });
}

TEST(Operations, AreNearTheTruthWhereTheyAreHard) {
    constexpr auto one = [](Numbers&) { return 1.0; };
    constexpr auto any = [](Numbers& n) { return n.sized(-1074, 1023); };
    constexpr Range angles[] = {{"of_turns", [](Numbers& n) { return 1e9 * n.share(); }, one},
                                {"of_many_turns", [](Numbers& n) { return n.sized(28, 62); }, one},
                                {"small", [](Numbers& n) { return n.sized(-1074, 0); }, one}};
    check_errors(Op::sine, angles, 1.5);
    check_errors(Op::cosine, angles, 1.5);
    constexpr Range exponents[] = {{"all", [](Numbers& n) { return 1420 * n.share() - 710; }, one},
                                   {"vanishing", [](Numbers& n) { return -708 - 40 * n.share(); }, one}};
    check_errors(Op::exponential, exponents, 1.15);
    constexpr Range logarithms[] = {{"near_1", [](Numbers& n) { return 1 + n.sized(-50, -1); }, one},
                                    {"all", [](Numbers& n) { return std::fabs(n.sized(-1074, 1023)); }, one}};
    check_errors(Op::logarithm, logarithms, 0.9);
    constexpr Range tangents[] = {{"all", [](Numbers& n) { return n.sized(-1074, 6); }, one}};
    check_errors(Op::hyperbolic_tangent, tangents, 1.15);
    constexpr Range points[] = {{"all", any, any},
                                {"of_subnormal_size", any, [](Numbers& n) { return n.sized(-1074, -1000); }}};
    check_errors(Op::arc_tangent, points, 1.5);
    constexpr Range powers[] = {
        {"near_1", [](Numbers& n) { return 1 + n.sized(-50, -1); }, [](Numbers& n) { return n.sized(-5, 40); }},
        {"all", [](Numbers& n) { return std::fabs(n.sized(-1074, 1023)); }, [](Numbers& n) { return n.sized(-10, 3); }},
        {"of_negative", [](Numbers& n) { return n.sized(-10, 10); },
         [](Numbers& n) { return std::floor(200 * n.share() - 100); }}};
    check_errors(Op::power, powers, 1.15);
    // Where sines vanish: multiples of pi as near as doubles come. 80 bits are too few to say where cosines do.
    for (int k = 1; k < 30000; ++k) {
        const double x = k * 3.14159265358979323846;
        EXPECT_LE(error_of(result_of(Op::sine, x), std::sin(static_cast<long double>(x))), 1.5) << k;
    }
}

TEST(Operations, AreWhatCSaysOfOddNumbers) {
    for_each_operation([&](Op op) {
        if (op == Op::least || op == Op::most) return; // of what is no number the other or none, by order
        for (const double a : odd_numbers)
            for (const double b : odd_numbers) {
                const double found = result_of(op, a, b, 3);
                const long double exact = reference(op, a, b, 3);
                EXPECT_LE(error_of(found, exact), 2)
                    << "operation " << static_cast<int>(op) << " of " << a << ", " << b;
                // Sums of sine's series lose the sign of 0.
                if (!std::isnan(found) && op != Op::sine) {
                    EXPECT_EQ(std::signbit(found), std::signbit(exact))
                        << "operation " << static_cast<int>(op) << " of " << a << ", " << b;
                }
            }
    });
    EXPECT_EQ(result_of(Op::cosine, 0), 1);
    // No sine is above 1.
    for (int i = -200000; i <= 200000; ++i) {
        EXPECT_LE(result_of(Op::sine, 1.5707963267948966 + 1e-9 * i), 1);
        EXPECT_LE(result_of(Op::cosine, 1e-9 * i), 1);
    }
    // Powers that are whole numbers have no error.
    for (int a = 1; a < 30; ++a)
        for (int b = 0; b <= 3; ++b) EXPECT_EQ(result_of(Op::power, a, b), std::pow(a, b));
}

} // namespace
} // namespace skein
