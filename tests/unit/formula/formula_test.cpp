// The language of formulas: values, derivatives against differences, units, and what is said of mistakes.
#include "formula/evaluate.hpp"
#include "formula/formula.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <random>

namespace skein {
namespace {

FormulaScope some_scope() {
    FormulaScope scope;
    scope.constants = {{"k", 2.5, "N/m^2"}, {"c", -0.75, ""}, {"speed", 3.0, "m/s"}, {"length_scale", 0.4, "m"}};
    scope.tables.push_back({.name = "gust", .at = {0, 1, 3}, .value = {1, 3, -1}, .unit = "m/s"});
    scope.tables.push_back({.name = "beat", .at = {0, 1, 2}, .value = {0, 1, 0}, .periodic = true});
    return scope;
}

/// x, y, z, vx, vy, vz, t, s, L, rod, X, Y, Z
constexpr std::array<double, variables> here = {0.3, -1.2, 0.7, 0.1, -0.4, 2.0, 1.7, 0.25, 1.0, 3.0, 0.2, -1.0, 0.6};

struct Read {
    Graph graph{some_scope().tables};
    std::vector<FormulaFault> faults;
    std::optional<FormulaValue> result;
    explicit Read(std::string_view text, std::string_view unit = "")
        : result(read_formula(graph, some_scope(), text, 0, unit, faults)) {}
    double value(const std::array<double, variables>& at = here) const { return nth(graph.values(at), result->node); }
};

double value_of(std::string_view text) {
    const Read read(text);
    EXPECT_TRUE(read.faults.empty()) << text << ": " << (read.faults.empty() ? "" : read.faults[0].message);
    return read.result ? read.value() : NAN;
}

TEST(Formulas, MeanWhatTheyDoOnPaper) {
    const auto [x, y, z, vx, vy, vz, t, s, length, rod, X, Y, Z] = here;
    const std::pair<const char*, double> cases[] = {
        {"1 + 2*3", 7},
        {"-2^2", -4},
        {"2^3^2", 512},
        {"2**-1", 0.5},
        {"2 - 3 - 4", -5},
        {"12/3/2", 2},
        {" ( 1+1 ) * .5e1 ", 10},
        {"1e-3", 1e-3},
        {"2*e", 2 * std::numbers::e},
        {"1*x*y - 1*z/vx", x * y - z / vx},
        {"sin(2*x)^2 + cos(2*x)^2", 1},
        {"exp(log(2.5))", 2.5},
        {"tan(1.1)", std::tan(1.1)},
        {"atan2(y, x)", std::atan2(y, x)},
        {"atan(0.3)", std::atan(0.3)},
        {"tanh(0.4)", std::tanh(0.4)},
        {"hypot(x, y, z)", std::sqrt(x * x + y * y + z * z)},
        {"min(x, y, z)", y},
        {"max(x, y, z)", z},
        {"abs(y)", -y},
        {"floor(-1.5) + floor(1.5)", -1},
        {"mod(t, 0.5)", 0.2},
        {"sign(y) + step(x)", 0},
        {"step(0)", 1},
        {"ramp(t, 2)", 0.85},
        {"ramp(t - 1.8, 2) + ramp(t, 1)", 1},
        {"if(x < y, 1, 2)", 2},
        {"if(x >= y, if(t != 1.7, 3, 4), 5)", 4},
        {"(s == 0.25) + (s > 0.25) + (s <= 0.25)", 2},
        {"k*length_scale + c", 2.5 * 0.4 - 0.75},
        {"gust(t)", 3 - 2 * 0.7},
        {"gust(0*t - 1) + gust(9)", 0},
        {"beat(t + 2)", 0.3},
        {"x^4 - x*x*x*x", 0},
        {"2^0.5 - sqrt(2)", 0},
        {"x^1.5", std::pow(x, 1.5)},
        {"2^-3", 0.125},
        {"s/L + rod", 3.25},
        {"X + Y + Z", X + Y + Z},
    };
    for (const auto& [text, expected] : cases) {
        EXPECT_NEAR(value_of(text), expected, 1e-15 * (1 + std::abs(expected))) << text;
    }
    EXPECT_EQ(value_of("-vy*0.5"), 0.2);
}

TEST(Formulas, HaveTheDerivativesThatDifferencesHave) {
    for (const char* text :
         {"1*x^3*y - 1*z", "sin(3*x)*cos(2*y)/exp(1*z)", "sqrt(x^2 + y^2 + z^2)", "log(2 + 1*x*y*y)", "tanh(1*x - 2*y)",
          "atan2(y, x)", "(1*x)^(1*y)", "(x*x + 2)^1.5", "min(1*x, 1*y*z)*max(x, z)", "if(x > y, x*x, 1*y*y*z)",
          "abs(y)*x", "gust(1*x + 1*t)", "1/(x + 2*y)", "hypot(x, y)", "tan(1*x)", "mod(x, length_scale)",
          "ramp(1*x, 2)*y", "-x/y/z"}) {
        Read read(text);
        ASSERT_TRUE(read.result) << text << ": " << read.faults[0].message;
        for (const Variable v : {Variable::x, Variable::y, Variable::z}) {
            const int derivative = read.graph.derivative(read.result->node, v);
            const double h = 1e-5;
            auto up = here, down = here;
            nth(up, v) += h;
            nth(down, v) -= h;
            const double difference = (read.value(up) - read.value(down)) / (2 * h);
            EXPECT_NEAR(nth(read.graph.values(here), derivative), difference, 1e-8 * (1 + std::abs(difference)))
                << text << " by " << variable_names[static_cast<int>(v)].name;
        }
    }
}

TEST(Formulas, CheckUnits) {
    const auto said = [](const char* text, const char* unit) {
        const Read read(text, unit);
        return read.faults.empty() ? std::string() : read.faults[0].message;
    };
    EXPECT_EQ(said("-k*x", "N/m"), "");
    EXPECT_EQ(said("-2*x", "N/m"), "") << "plain numbers fit any unit";
    EXPECT_EQ(said("k*x", "m/s^2"), "the result is in N/m, and m/s^2 is expected");
    EXPECT_EQ(said("x + t", ""),
              "the parts of a sum need one unit: 'x' is in m, 't' is in s; multiply 't' by a constant in m/s");
    EXPECT_EQ(said("if(x > t, 1, 2)", ""),
              "both sides of a comparison need one unit: 'x' is in m, 't' is in s; multiply 't' by a constant in m/s");
    EXPECT_EQ(said("sin(x)", ""), "'sin' needs a pure number, but gets one in m");
    EXPECT_EQ(said("sin(2*pi*t)", ""), "") << "a plain number among the factors";
    EXPECT_EQ(said("sin(x/length_scale)", ""), "");
    EXPECT_EQ(said("sqrt(x^2 + y^2) + vx", ""), "the parts of a sum need one unit: 'sqrt(x^2 + y^2)' is in m, 'vx' is "
                                                "in m/s; multiply 'vx' by a constant in s");
    EXPECT_EQ(said("gust(x)", ""), "'gust' needs a value in s, but gets one in m");
    EXPECT_EQ(said("gust(t)*k*t", "N/m"), "");
    EXPECT_EQ(said("min(x, t)", ""),
              "the values of 'min' need one unit: 'x' is in m, 't' is in s; multiply 't' by a constant in m/s");
    EXPECT_EQ(unit_text(*parse_unit("kg m/s^2")), "N");
    EXPECT_EQ(unit_text(*parse_unit("kg/m s^2")), "N/m^2");
    EXPECT_EQ(unit_text(*parse_unit("m^3 s/A^2")), "m^3 s/A^2");
    EXPECT_FALSE(parse_unit("mm") || parse_unit("N/") || parse_unit("N/m/s") || parse_unit("") || parse_unit("m^"));
}

TEST(Formulas, SayWhatIsWrongAndWhere) {
    struct Case {
        const char* text;
        std::size_t begin, length;
        const char* said;
    };
    for (const Case& c :
         {Case{"2*spead", 2, 5, "'spead' is not known; did you mean 'speed'?"},
          Case{"2*(x + y", 8, 1, "')' is expected here"}, Case{"sin(1, 2)", 0, 3, "'sin' takes 1 value, not 2"},
          Case{"min(x)", 0, 3, "'min' takes 2 to 16 values, not 1"},
          Case{"x y", 2, 1, "an operator is expected here, + - * / ^ or a comparison"},
          Case{"2*", 2, 1, "a value is expected here: a number, a name or a bracket"},
          Case{"", 0, 1, "a value is expected here: a number, a name or a bracket"},
          Case{"sin", 0, 3, "'sin' is a function: sin(...)"}, Case{"gust + 1", 0, 4, "'gust' is a table: gust(t)"},
          Case{"k(2)", 0, 1, "'k' is not a function: put a * before the bracket"},
          Case{"max(1, 2", 8, 1, "',' or ')' is expected here"}, Case{"1e999", 0, 5, "'1e999' is out of range"},
          Case{"x # y", 2, 1, "an operator is expected here, + - * / ^ or a comparison"}}) {
        const Read read(c.text);
        ASSERT_EQ(read.faults.size(), 1u) << c.text;
        EXPECT_EQ(read.faults[0].part.begin, c.begin) << c.text;
        EXPECT_EQ(read.faults[0].part.length, c.length) << c.text;
        EXPECT_EQ(read.faults[0].message, c.said);
    }
    for (const std::string& text :
         {std::string(5000, 'x'), std::string(2000, '('), std::string(3000, '-') + "x", "x" + std::string(3000, '^')})
        EXPECT_EQ(Read(text).faults.size(), 1u);
}

TEST(Formulas, AreSplitByWhatTheyChangeWith) {
    Graph graph;
    std::vector<FormulaFault> faults;
    std::vector<int> nodes;
    for (const char* text : {"sin(2*pi*t)*s^2*x", "3*t", "exp(-(1*s))"})
        nodes.push_back(read_formula(graph, {}, text, 0, "", faults)->node);
    const auto program = compiled(graph, nodes);
    ASSERT_TRUE(program);
    ASSERT_EQ(program->state.code.size(), 1u)
        << "the sine is known once a step, the square and the exponential once a run";
    EXPECT_TRUE(program->state.code[0].then) << "two products";
    EXPECT_EQ(program->time.outputs.size(), 2u);
    EXPECT_EQ(program->place.outputs.size(), 2u);
    EXPECT_EQ(program->state.inputs.size(), 5u);
}

/// That a strip gives at each place the bits of the nodes alone, for variables of the state.
void expect_bits_of_nodes(const Graph& graph, const std::vector<int>& nodes) {
    const auto program = compiled(graph, nodes);
    ASSERT_TRUE(program);
    const InstructionList& list = program->state;
    constexpr int W = 4, count = 13;
    Pack<W> in[variables][count];
    for (int v = 0; v < variables; ++v)
        for (int i = 0; i < count; ++i)
            for (int l = 0; l < W; ++l) in[v][i].set(l, std::sin(1.0 + 3 * v + 0.7 * i + 11 * l));
    Strided<W> source[InstructionList::most_sources];
    Pack<W> same[InstructionList::most_sources];
    StripRegisters<W> registers;
    for (std::size_t i = 0; i < list.constants.size(); ++i) {
        same[i] = Pack<W>(list.constants[i]);
        source[static_cast<std::size_t>(list.registers) + i] = {&same[i], 0};
    }
    for (std::size_t i = 0; i < list.inputs.size(); ++i)
        source[static_cast<std::size_t>(list.first_input()) + i] = {in[list.inputs[i]], 1};
    evaluate<W>(list, program->tables, source, registers, count);
    for (int i = 0; i < count; ++i)
        for (int l = 0; l < W; ++l) {
            std::array<double, variables> at{};
            for (int v = 0; v < variables; ++v) nth(at, v) = in[v][i][l];
            const auto values = graph.values(at);
            for (std::size_t o = 0; o < nodes.size(); ++o) {
                const double strip = source[list.outputs[o]][i][l], alone = nth(values, nodes[o]);
                if (std::isnan(strip) && std::isnan(alone)) continue;
                EXPECT_EQ(std::bit_cast<std::uint64_t>(strip), std::bit_cast<std::uint64_t>(alone))
                    << o << " at " << i << ", " << l;
            }
        }
}

/// Strips of any length, and registers that are used again.
TEST(Formulas, GiveOverStripsWhatTheyGiveAlone) {
    Graph graph(some_scope().tables);
    std::vector<FormulaFault> faults;
    std::vector<int> nodes;
    for (const char* text : {"1*x*y + 1*z*vx - (x - y)*(z - 1*vx)/(1 + x^2 + y^2)",
                             "if(x < y, gust(1*x), 1*sqrt(x*x + y*y)) - atan2(x, y)", "exp(-(1*x)^2)*sin(4*y)"})
        nodes.push_back(read_formula(graph, some_scope(), text, 0, "", faults)->node);
    expect_bits_of_nodes(graph, nodes);
}

/// Each pair of operations in one instruction, either way round.
TEST(Formulas, WorkOutTwoOperationsAtOnce) {
    for (const char first : std::string("+-*/"))
        for (const char then : std::string("+-*/"))
            for (const bool reversed : {false, true}) {
                Graph graph;
                std::vector<FormulaFault> faults;
                const std::string inner = std::string("(1*x") + first + "y)";
                const std::string text = reversed ? std::string("1*vz") + then + inner : inner + then + "vz";
                const int node = read_formula(graph, {}, text, 0, "", faults)->node;
                EXPECT_EQ(compiled(graph, std::array{node})->state.code.size(), 1u) << text;
                expect_bits_of_nodes(graph, {node});
            }
}

/// What is used twice is worked out once, and registers are given back in time: sums, differences, products and
/// quotients of any of those before them.
TEST(Formulas, OfManyOperationsGiveTheBitsOfEach) {
    std::mt19937 random(5);
    for (int trial = 0; trial < 200; ++trial) {
        Graph graph;
        std::vector<int> nodes = {graph.constant(1.5)};
        for (int v = 0; v < 6; ++v) nodes.push_back(graph.variable(static_cast<Variable>(v)));
        const auto any = [&] { return nodes[nodes.size() - 1 - random() % std::min<std::size_t>(nodes.size(), 9)]; };
        for (int k = 0; k < 30; ++k) {
            constexpr Op ops[] = {Op::add, Op::subtract, Op::multiply, Op::divide, Op::negative, Op::choice};
            const Op op = ops[random() % std::size(ops)];
            const int a = any(), b = any(), c = any();
            nodes.push_back(graph.make(op, a, operands_of(op) > 1 ? b : -1, operands_of(op) > 2 ? c : -1));
        }
        expect_bits_of_nodes(graph, {nodes.back(), any(), any()});
    }
}

} // namespace
} // namespace skein
