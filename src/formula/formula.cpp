#include "formula/formula.hpp"

#include "core/nearest.hpp"

#include <tao/pegtl.hpp>

#include <charconv>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace skein {

namespace {

namespace peg = tao::pegtl;

/// A function of one word. Functions of several words are written out below.
struct Function {
    std::string_view name;
    int least, most; ///< number of arguments
};
constexpr Function functions[] = {{"sin", 1, 1},   {"cos", 1, 1},  {"tan", 1, 1},   {"exp", 1, 1},  {"log", 1, 1},
                                  {"sqrt", 1, 1},  {"abs", 1, 1},  {"floor", 1, 1}, {"tanh", 1, 1}, {"atan", 1, 1},
                                  {"sign", 1, 1},  {"step", 1, 1}, {"min", 2, 16},  {"max", 2, 16}, {"atan2", 2, 2},
                                  {"hypot", 2, 3}, {"mod", 2, 2},  {"ramp", 2, 2},  {"if", 3, 3}};

struct Refusal {
    std::size_t begin, length;
    std::string message;
};

/// A value of the stack, with the text that it stands for.
struct Item {
    int node;
    std::optional<Unit> unit;
    std::size_t begin, end;
};

/// Builds the graph while the grammar reads, with values on a stack.
class Builder {
public:
    Builder(Graph& graph, const FormulaScope& scope, std::string_view text, int number)
        : graph_(graph), scope_(scope), text_(text), number_(number) {}

    void number(std::string_view text, std::size_t begin) {
        double value = 0;
        const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
        if (read.ec != std::errc() || !std::isfinite(value))
            throw Refusal{begin, text.size(), fmt::format("'{}' is out of range", text)};
        push(graph_.constant(value), std::nullopt, begin, begin + text.size());
    }

    void name(std::string_view text, std::size_t begin) {
        const std::size_t end = begin + text.size();
        if (text == "pi") return push(graph_.constant(std::numbers::pi), Unit{}, begin, end);
        if (text == "e") return push(graph_.constant(std::numbers::e), Unit{}, begin, end);
        for (int v = 0; v < variables; ++v)
            if (variable_names[v].name == text)
                return push(graph_.variable(static_cast<Variable>(v)), unit_of(variable_names[v].unit), begin, end);
        for (const FormulaConstant& c : scope_.constants)
            if (c.name == text) return push(graph_.constant(c.value), unit_of(c.unit), begin, end);
        for (const Function& f : functions)
            if (f.name == text) throw Refusal{begin, text.size(), fmt::format("'{0}' is a function: {0}(...)", text)};
        for (const FormulaTable& t : scope_.tables)
            if (t.name == text) throw Refusal{begin, text.size(), fmt::format("'{0}' is a table: {0}(t)", text)};
        unknown(text, begin);
    }

    void open(std::string_view text, std::size_t begin) { calls_.push_back({text, begin, stack_.size()}); }
    void close(std::size_t end) {
        const Call call = calls_.back();
        calls_.pop_back();
        std::vector<Item> given(stack_.begin() + static_cast<long>(call.height), stack_.end());
        stack_.resize(call.height);
        const Item whole{-1, std::nullopt, call.begin, end};
        for (std::size_t i = 0; i < scope_.tables.size(); ++i)
            if (scope_.tables[i].name == call.name) {
                need(call, given, 1, 1);
                agree(given[0], unit_of(scope_.tables[i].at_unit), call.name);
                return push(graph_.tabulated(static_cast<int>(i), given[0].node), unit_of(scope_.tables[i].unit),
                            whole.begin, end);
            }
        for (const Function& f : functions)
            if (f.name == call.name) {
                need(call, given, f.least, f.most);
                const auto [node, unit] = called(call.name, given);
                return push(node, unit, whole.begin, end);
            }
        for (const std::string_view known : known_names(scope_))
            if (known == call.name)
                throw Refusal{call.begin, call.name.size(),
                              fmt::format("'{}' is not a function: put a * before the bracket", call.name)};
        unknown(call.name, call.begin);
    }

    void negate(std::size_t begin) {
        Item& a = stack_.back();
        push_over(1, graph_.make(Op::negative, a.node), a.unit, begin);
    }
    void binary(char op) {
        const Item b = stack_.back(), a = stack_[stack_.size() - 2];
        const auto join = [&](Op o, std::optional<Unit> unit) {
            push_over(2, graph_.make(o, a.node, b.node), unit, a.begin);
        };
        const auto both = [&](auto combine) {
            return a.unit && b.unit ? std::optional(combine(*a.unit, *b.unit)) : std::nullopt;
        };
        switch (op) {
        case '+':
            return join(Op::add, alike(a, b, "the parts of a sum"));
        case '-':
            return join(Op::subtract, alike(a, b, "the parts of a difference"));
        case '*':
            return join(Op::multiply, both([](const Unit& u, const Unit& v) { return u * v; }));
        case '/':
            return join(Op::divide, both([](const Unit& u, const Unit& v) { return u / v; }));
        default:
            return raise();
        }
    }
    void compare(std::string_view op) {
        const Item b = stack_.back(), a = stack_[stack_.size() - 2];
        alike(a, b, "both sides of a comparison");
        int r;
        if (op == "<") r = graph_.make(Op::less, a.node, b.node);
        else if (op == ">") r = graph_.make(Op::less, b.node, a.node);
        else if (op == "<=") r = graph_.make(Op::less_equal, a.node, b.node);
        else if (op == ">=") r = graph_.make(Op::less_equal, b.node, a.node);
        else r = graph_.make(Op::equal, a.node, b.node);
        if (op == "!=") r = graph_.make(Op::subtract, graph_.constant(1), r);
        push_over(2, r, Unit{}, a.begin);
    }
    void bracket(std::size_t begin, std::size_t end) {
        stack_.back().begin = begin;
        stack_.back().end = end;
    }

    const Item& result() const { return stack_.back(); }

private:
    struct Call {
        std::string_view name;
        std::size_t begin, height;
    };

    static std::optional<Unit> unit_of(std::string_view text) { return text.empty() ? std::nullopt : parse_unit(text); }

    void push(int node, std::optional<Unit> unit, std::size_t begin, std::size_t end) {
        graph_.mark(node, {begin, end - begin, number_});
        stack_.push_back({node, unit, begin, end});
    }
    void push_over(std::size_t operands, int node, std::optional<Unit> unit, std::size_t begin) {
        const std::size_t end = stack_.back().end;
        stack_.resize(stack_.size() - operands);
        push(node, unit, begin, end);
    }

    [[noreturn]] void unknown(std::string_view name, std::size_t begin) const {
        throw Refusal{begin, name.size(),
                      fmt::format("'{}' is not known{}", name, suggestion(name, known_names(scope_), "there are"))};
    }
    void need(const Call& call, const std::vector<Item>& given, int least, int most) const {
        const int n = static_cast<int>(given.size());
        if (n >= least && n <= most) return;
        const std::string wanted = least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most);
        throw Refusal{call.begin, call.name.size(),
                      fmt::format("'{}' takes {} value{}, not {}", call.name, wanted, most == 1 ? "" : "s", n)};
    }
    void agree(const Item& a, const std::optional<Unit>& unit, std::string_view what) const {
        if (unit && a.unit && !(*a.unit == *unit))
            throw Refusal{a.begin, a.end - a.begin,
                          fmt::format("'{}' needs {}, but gets one in {}", what,
                                      unit->pure() ? "a pure number" : "a value in " + unit_text(*unit),
                                      unit_text(*a.unit))};
    }
    /// Text of a value as the scene has it.
    std::string words(const Item& item) const {
        constexpr std::size_t longest = 40;
        std::string_view part = text_.substr(item.begin, item.end - item.begin);
        while (part.ends_with(' ')) part.remove_suffix(1);
        const char* const unit = item.unit->pure() ? "has no unit" : "is in ";
        return fmt::format("'{}{}' {}{}", part.substr(0, longest), part.size() > longest ? "..." : "", unit,
                           item.unit->pure() ? "" : unit_text(*item.unit));
    }
    /// Common unit of a and b.
    std::optional<Unit> alike(const Item& a, const Item& b, std::string_view what) const {
        if (a.unit && b.unit && !(*a.unit == *b.unit)) {
            const bool first = b.unit->pure();
            const Item& odd = first ? a : b;
            const std::string_view part = text_.substr(odd.begin, odd.end - odd.begin);
            const std::string cure =
                a.unit->pure() || first
                    ? fmt::format("divide '{}' by a constant in {}", part, unit_text(*odd.unit))
                    : fmt::format("multiply '{}' by a constant in {}", part, unit_text(*a.unit / *b.unit));
            throw Refusal{a.begin, b.end - a.begin,
                          fmt::format("{} need one unit: {}, {}; {}", what, words(a), words(b), cure)};
        }
        return a.unit ? b.unit ? a.unit : std::nullopt : std::nullopt;
    }

    /// a^b. Whole powers become products, and halves roots.
    void raise() {
        const Item b = stack_.back(), a = stack_[stack_.size() - 2];
        agree(b, Unit{}, "^");
        const auto exponent = graph_.number(b.node);
        std::optional<Unit> unit;
        if (a.unit && exponent) unit = a.unit->raised(*exponent);
        else if (a.unit && a.unit->pure()) unit = Unit{};
        else if (a.unit)
            throw Refusal{a.begin, a.end - a.begin,
                          fmt::format("a quantity in {} needs a constant exponent", unit_text(*a.unit))};
        int r;
        if (exponent && std::abs(*exponent) <= 16 && *exponent == std::floor(*exponent))
            r = graph_.whole_power(a.node, static_cast<int>(*exponent));
        else if (exponent == 0.5) r = graph_.make(Op::root, a.node);
        else r = graph_.make(Op::power, a.node, b.node);
        push_over(2, r, unit, a.begin);
    }

    std::pair<int, std::optional<Unit>> called(std::string_view f, const std::vector<Item>& given) {
        const Item& a = given[0];
        const std::optional<Unit> pure = Unit{};
        const auto of_pure = [&](Op op) {
            agree(a, pure, f);
            return std::pair(graph_.make(op, a.node), pure);
        };
        const auto of_two = [&](Op op, int x, int y) { return graph_.make(op, x, y); };
        if (f == "sin") return of_pure(Op::sine);
        if (f == "cos") return of_pure(Op::cosine);
        if (f == "exp") return of_pure(Op::exponential);
        if (f == "log") return of_pure(Op::logarithm);
        if (f == "tanh") return of_pure(Op::hyperbolic_tangent);
        if (f == "floor") return of_pure(Op::floor);
        if (f == "tan") return {of_two(Op::divide, of_pure(Op::sine).first, of_pure(Op::cosine).first), pure};
        if (f == "atan") {
            agree(a, pure, f);
            return {of_two(Op::arc_tangent, a.node, graph_.constant(1)), pure};
        }
        if (f == "sqrt")
            return {graph_.make(Op::root, a.node), a.unit ? std::optional(a.unit->raised(0.5)) : std::nullopt};
        if (f == "abs") return {graph_.make(Op::absolute, a.node), a.unit};
        const int zero = graph_.constant(0), one = graph_.constant(1);
        if (f == "step") return {graph_.make(Op::choice, of_two(Op::less, a.node, zero), zero, one), pure};
        if (f == "sign")
            return {graph_.make(Op::choice, of_two(Op::less, a.node, zero), graph_.constant(-1),
                                of_two(Op::less, zero, a.node)),
                    pure};
        if (f == "if") {
            agree(a, pure, f);
            return {graph_.make(Op::choice, a.node, given[1].node, given[2].node),
                    alike(given[1], given[2], "both choices of 'if'")};
        }
        const Item& b = given[1];
        const std::string values = fmt::format("the values of '{}'", f);
        std::optional<Unit> unit = alike(a, b, values);
        if (f == "atan2") return {of_two(Op::arc_tangent, a.node, b.node), pure};
        if (f == "mod")
            return {of_two(Op::subtract, a.node,
                           of_two(Op::multiply, b.node, graph_.make(Op::floor, of_two(Op::divide, a.node, b.node)))),
                    unit};
        if (f == "ramp") // 0 before a, 1 from b on
            return {of_two(Op::most, zero, of_two(Op::least, one, of_two(Op::divide, a.node, b.node))), pure};
        int r = f == "hypot" ? of_two(Op::multiply, a.node, a.node) : a.node;
        for (std::size_t i = 1; i < given.size(); ++i) {
            if (unit) unit = alike(a, given[i], values);
            const int next = given[i].node;
            if (f == "hypot") r = of_two(Op::add, r, of_two(Op::multiply, next, next));
            else r = of_two(f == "min" ? Op::least : Op::most, r, next);
        }
        return {f == "hypot" ? graph_.make(Op::root, r) : r, unit};
    }

    Graph& graph_;
    const FormulaScope& scope_;
    std::string_view text_;
    int number_;
    std::vector<Item> stack_;
    std::vector<Call> calls_;
};

// Grammar. Precedence rises from comparison over sum, product and sign to power.
struct expression;
struct product;
struct unary;
struct blank : peg::star<peg::one<' ', '\t', '\n', '\r'>> {};
struct exponent : peg::seq<peg::one<'e', 'E'>, peg::opt<peg::one<'+', '-'>>, peg::plus<peg::digit>> {};
struct figures : peg::seq<peg::sor<peg::seq<peg::plus<peg::digit>, peg::opt<peg::one<'.'>, peg::star<peg::digit>>>,
                                   peg::seq<peg::one<'.'>, peg::plus<peg::digit>>>,
                          peg::opt<exponent>> {};
struct word : peg::identifier {};
struct value_name : word {};
struct call_begin : peg::seq<word, blank, peg::one<'('>, blank> {};
struct call_end : peg::one<')'> {};
struct comma : peg::seq<peg::one<','>, blank> {};
struct call
    : peg::seq<call_begin, peg::must<expression>, peg::star<comma, peg::must<expression>>, peg::must<call_end>> {};
struct bracket_end : peg::one<')'> {};
struct bracket : peg::seq<peg::one<'('>, blank, peg::must<expression>, peg::must<bracket_end>> {};
struct primary : peg::seq<peg::sor<figures, call, value_name, bracket>, blank> {};
struct power_tail : peg::seq<peg::sor<peg::one<'^'>, peg::string<'*', '*'>>, blank, peg::must<unary>> {};
struct power : peg::seq<primary, peg::opt<power_tail>> {};
struct negation : peg::seq<peg::one<'-'>, blank, peg::must<unary>> {};
struct plus_sign : peg::seq<peg::one<'+'>, blank, peg::must<unary>> {};
struct unary : peg::sor<negation, plus_sign, power> {};
struct times : peg::seq<peg::one<'*'>, blank, peg::must<unary>> {};
struct over : peg::seq<peg::one<'/'>, blank, peg::must<unary>> {};
struct product : peg::seq<unary, peg::star<peg::sor<times, over>>> {};
struct plus_term : peg::seq<peg::one<'+'>, blank, peg::must<product>> {};
struct minus_term : peg::seq<peg::one<'-'>, blank, peg::must<product>> {};
struct sum : peg::seq<product, peg::star<peg::sor<plus_term, minus_term>>> {};
struct comparison : peg::seq<peg::sor<peg::string<'<', '='>, peg::string<'>', '='>, peg::string<'=', '='>,
                                      peg::string<'!', '='>, peg::one<'<', '>'>>,
                             blank, peg::must<sum>> {};
struct expression : peg::seq<sum, peg::opt<comparison>> {};
struct whole : peg::seq<blank, peg::must<expression>, peg::must<peg::eof>> {};

template <class Rule> struct Action : peg::nothing<Rule> {};
template <class In> std::size_t begin_of(const In& in) { return in.position().byte; }
template <class In> std::size_t end_of(const In& in) { return in.position().byte + in.size(); }
#define SKEIN_ON(rule)                                                                                                 \
    template <> struct Action<rule> { template <class In> static void apply(const In& in, Builder& build); };          \
    template <class In> void Action<rule>::apply([[maybe_unused]] const In& in, Builder& build)
SKEIN_ON(figures) { build.number(in.string_view(), begin_of(in)); }
SKEIN_ON(value_name) { build.name(in.string_view(), begin_of(in)); }
SKEIN_ON(call_begin) {
    const std::string_view text = in.string_view();
    build.open(text.substr(0, text.find_first_of(" \t\n\r(")), begin_of(in));
}
SKEIN_ON(call_end) { build.close(end_of(in)); }
SKEIN_ON(bracket) { build.bracket(begin_of(in), end_of(in)); }
SKEIN_ON(power_tail) { build.binary('^'); }
SKEIN_ON(negation) { build.negate(begin_of(in)); }
SKEIN_ON(times) { build.binary('*'); }
SKEIN_ON(over) { build.binary('/'); }
SKEIN_ON(plus_term) { build.binary('+'); }
SKEIN_ON(minus_term) { build.binary('-'); }
SKEIN_ON(comparison) {
    const std::string_view text = in.string_view();
    build.compare(text.substr(0, text[1] == '=' ? 2 : 1));
}
#undef SKEIN_ON

/// Message where a rule must match and does not.
template <class Rule> constexpr const char* expected = "a value is expected here: a number, a name or a bracket";
template <> constexpr const char* expected<call_end> = "',' or ')' is expected here";
template <> constexpr const char* expected<bracket_end> = "')' is expected here";
template <> constexpr const char* expected<peg::eof> = "an operator is expected here, + - * / ^ or a comparison";

template <class Rule> struct Control : peg::normal<Rule> {
    template <class In, class... State> [[noreturn]] static void raise(const In& in, State&&...) {
        throw Refusal{in.position().byte, 1, expected<Rule>};
    }
};

void refuse_depth(std::string_view text) {
    constexpr std::size_t longest = 4000;
    constexpr int deepest = 60;
    if (text.size() > longest) throw Refusal{0, 1, fmt::format("the formula has more than {} characters", longest)};
    int depth = 0;
    std::size_t signs = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '(' && ++depth > deepest)
            throw Refusal{i, 1, fmt::format("brackets are nested more than {} deep", deepest)};
        if (text[i] == ')') --depth;
        signs = text[i] == '-' || text[i] == '+' || text[i] == '^' || text[i] == '*' ? signs + 1
                : text[i] == ' '                                                     ? signs
                                                                                     : 0;
        if (signs > 8) throw Refusal{i, 1, "too many operators in a row"};
    }
}

} // namespace

void add_faults(const std::string& key, std::span<const FormulaFault> faults, Objections& objections) {
    for (const FormulaFault& fault : faults) {
        const std::string message = fmt::format("'{}': {}", key, fault.message);
        if (fault.part.formula < 0) objections.add(key, message);
        else
            objections.add_within(fmt::format("{}.{}", key, fault.part.formula), fault.part.begin, fault.part.length,
                                  message);
    }
}

std::vector<std::string_view> known_names(const FormulaScope& scope) {
    std::vector<std::string_view> names = {"pi", "e"};
    for (const VariableEntry& v : variable_names) names.push_back(v.name);
    for (const Function& f : functions) names.push_back(f.name);
    for (const FormulaConstant& c : scope.constants) names.push_back(c.name);
    for (const FormulaTable& t : scope.tables) names.push_back(t.name);
    return names;
}

std::optional<FormulaValue> read_formula(Graph& graph, const FormulaScope& scope, std::string_view text, int number,
                                         std::string_view expected_unit, std::vector<FormulaFault>& faults) {
    try {
        refuse_depth(text);
        Builder build(graph, scope, text, number);
        peg::memory_input in(text.data(), text.size(), "");
        peg::parse<whole, Action, Control>(in, build);
        const Item& r = build.result();
        const auto unit = parse_unit(expected_unit);
        if (unit && r.unit && !(*r.unit == *unit))
            throw Refusal{0, std::max<std::size_t>(1, text.size()),
                          fmt::format("the result is in {}, and {} is expected", unit_text(*r.unit), unit_text(*unit))};
        return FormulaValue{r.node, r.unit};
    } catch (const Refusal& r) {
        faults.push_back({{r.begin, r.length, number}, r.message});
        return std::nullopt;
    }
}

} // namespace skein
