#include "formula/graph.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <bit>

namespace skein {

int Graph::put(Node node) {
    const auto [entry, is_new] = known_.try_emplace(
        {node.op, node.of, std::bit_cast<std::uint64_t>(node.number), node.index}, static_cast<int>(nodes_.size()));
    if (is_new) nodes_.push_back(node);
    return entry->second;
}

double Graph::apply(const Node& node, double a, double b, double c) const {
    const FormulaTable* table =
        node.op == Op::tabulated || node.op == Op::tabulated_slope ? &nth(tables_, node.index) : nullptr;
    if (node.op == Op::tabulated) return (*table)(a);
    if (node.op == Op::tabulated_slope) return table->slope(a);
    Pack<1> r(0.0);
    with_operation(node.op, [&]<Op op>() { r = operate<op>(Pack<1>(a), Pack<1>(b), Pack<1>(c)); });
    return r[0];
}

int Graph::look_up(Op op, int table, int a) {
    Node node{.op = op, .of = {a, -1, -1}, .index = table, .changes = (*this)[a].changes};
    if (const auto x = number(a)) return constant(apply(node, *x, 0, 0));
    return put(node);
}

int Graph::make(Op op, int a, int b, int c) {
    const auto is = [&](int i, double value) { return i >= 0 && number(i) == value; };
    // Identities that change no value keep derivatives short.
    if (op == Op::add && is(a, 0)) return b;
    if ((op == Op::add || op == Op::subtract) && is(b, 0)) return a;
    if (op == Op::subtract && is(a, 0)) return make(Op::negative, b);
    if (op == Op::multiply && (is(a, 0) || is(b, 0))) return constant(0);
    if (op == Op::multiply && is(a, 1)) return b;
    if ((op == Op::multiply || op == Op::divide) && is(b, 1)) return a;
    if (op == Op::divide && is(a, 0) && !is(b, 0)) return a;
    if (op == Op::choice && b == c) return b;
    if (op == Op::choice && number(a)) return *number(a) != 0 ? b : c;

    Node node{.op = op, .of = {a, b, c}};
    bool known = true;
    double x[3] = {0, 0, 0};
    for (int i = 0; i < operands_of(op); ++i) {
        const Node& operand = (*this)[nth(node.of, i)];
        node.changes |= operand.changes;
        known = known && operand.op == Op::constant;
        x[i] = operand.number;
    }
    return known ? constant(apply(node, x[0], x[1], x[2])) : put(node);
}

int Graph::whole_power(int a, int n) {
    if (n < 0) return make(Op::divide, constant(1), whole_power(a, -n));
    if (n == 0) return constant(1);
    if (n == 1) return a;
    const int half = whole_power(a, n / 2), even = make(Op::multiply, half, half);
    return n % 2 == 0 ? even : make(Op::multiply, even, a);
}

int Graph::derivative(int node, Variable by) {
    const std::size_t count = to_index(node) + 1; // operands come first
    const int zero = constant(0);
    constant(1); // ahead of all nodes of derivatives
    std::vector<bool> needed(count, false);
    nth(needed, node) = true;
    for (std::size_t i = count; i-- > 0;)
        if (needed[i])
            for (const int operand : nodes_[i].of)
                if (operand >= 0) nth(needed, operand) = true;
    std::vector<int> d(count, -1);
    for (std::size_t i = 0; i < count; ++i) {
        if (!needed[i]) continue;
        const Node n = nodes_[i]; // a copy: the list grows
        const auto of = [&](int operand) { return operand >= 0 ? nth(d, operand) : zero; };
        d[i] = chain_rule(static_cast<int>(i), n, of(n.of[0]), of(n.of[1]), of(n.of[2]), by);
    }
    return nth(d, node);
}

int Graph::chain_rule(int self, const Node& n, int da, int db, int dc, Variable by) {
    const int a = n.of[0], b = n.of[1], zero = constant(0), one = constant(1);
    const auto times = [&](int x, int y) { return make(Op::multiply, x, y); };
    const auto over = [&](int x, int y) { return make(Op::divide, x, y); };
    const auto minus = [&](int x, int y) { return make(Op::subtract, x, y); };
    switch (n.op) {
    case Op::constant:
    case Op::floor:
    case Op::tabulated_slope:
    case Op::less:
    case Op::less_equal:
    case Op::equal:
        return zero;
    case Op::variable:
        return n.index == static_cast<int>(by) ? one : zero;
    case Op::negative:
        return make(Op::negative, da);
    case Op::absolute:
        return make(Op::choice, make(Op::less, a, zero), make(Op::negative, da), da);
    case Op::root:
        return over(da, times(constant(2), self));
    case Op::sine:
        return times(make(Op::cosine, a), da);
    case Op::cosine:
        return make(Op::negative, times(make(Op::sine, a), da));
    case Op::exponential:
        return times(self, da);
    case Op::logarithm:
        return over(da, a);
    case Op::hyperbolic_tangent:
        return times(minus(one, times(self, self)), da);
    case Op::tabulated:
        return times(look_up(Op::tabulated_slope, n.index, a), da);
    case Op::add:
        return make(Op::add, da, db);
    case Op::subtract:
        return minus(da, db);
    case Op::multiply:
        return make(Op::add, times(da, b), times(a, db));
    case Op::divide:
        return over(minus(da, times(self, db)), b);
    case Op::power: {
        const int by_base = times(times(b, make(Op::power, a, minus(b, one))), da);
        return db == zero ? by_base : make(Op::add, by_base, times(times(self, make(Op::logarithm, a)), db));
    }
    case Op::arc_tangent:
        return over(minus(times(b, da), times(a, db)), make(Op::add, times(a, a), times(b, b)));
    case Op::least:
        return make(Op::choice, make(Op::less, b, a), db, da);
    case Op::most:
        return make(Op::choice, make(Op::less, a, b), db, da);
    case Op::choice:
        return make(Op::choice, a, db, dc);
    }
    return zero;
}

bool Graph::varies_beyond(int node, std::span<const Variable> allowed) const {
    const Node& n = (*this)[node];
    if (n.op == Op::variable)
        return std::find(allowed.begin(), allowed.end(), static_cast<Variable>(n.index)) == allowed.end();
    return std::any_of(n.of.begin(), n.of.begin() + operands_of(n.op),
                       [&](int operand) { return varies_beyond(operand, allowed); });
}

std::vector<double> Graph::values(const std::array<double, variables>& at) const {
    std::vector<double> v(nodes_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        const Node& n = nodes_[i];
        const auto of = [&](std::size_t k) { return n.of[k] >= 0 ? nth(v, n.of[k]) : 0.0; };
        if (n.op == Op::constant) v[i] = n.number;
        else if (n.op == Op::variable) v[i] = nth(at, n.index);
        else v[i] = apply(n, of(0), of(1), of(2));
    }
    return v;
}

} // namespace skein
