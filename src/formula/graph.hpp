// Formulas as a graph. Each value stands once, however often it is written, and constants are folded. Operands come
// before the nodes that use them.
#pragma once

#include "formula/operation.hpp"
#include "formula/scope.hpp"
#include "skein/core/index.hpp"

#include <array>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

namespace skein {

/// Place of a value in the text of a formula, in bytes.
struct Part {
    std::size_t begin = 0, length = 0;
    int formula = -1; ///< number of the formula; -1 where the value is not written, as in a derivative
};

class Graph {
public:
    struct Node {
        Op op = Op::constant;
        std::array<int, 3> of{-1, -1, -1};
        double number = 0; ///< value of a constant
        int index = 0;     ///< number of the variable or table
        unsigned changes = 0;
        Part part;
    };

    explicit Graph(std::vector<FormulaTable> tables = {}) : tables_(std::move(tables)) {}

    const std::vector<Node>& nodes() const { return nodes_; }
    const Node& operator[](int i) const { return nth(nodes_, i); }
    const std::vector<FormulaTable>& tables() const { return tables_; }

    int constant(double value) { return put({.op = Op::constant, .number = value}); }
    int variable(Variable v) {
        return put({.op = Op::variable, .index = static_cast<int>(v), .changes = changes_with(v)});
    }
    int tabulated(int table, int a) { return look_up(Op::tabulated, table, a); }
    int make(Op op, int a, int b = -1, int c = -1);
    /// a^n for a whole number n.
    int whole_power(int a, int n);

    /// Value of a constant; nothing for other nodes.
    std::optional<double> number(int i) const {
        return (*this)[i].op == Op::constant ? std::optional((*this)[i].number) : std::nullopt;
    }
    /// True where a value depends on a variable that is not in `allowed`.
    bool varies_beyond(int node, std::span<const Variable> allowed) const;
    void mark(int i, const Part& part) {
        if (Part& p = nth(nodes_, i).part; p.formula < 0) p = part;
    }

    /// d(node)/d(variable).
    int derivative(int node, Variable by);

    /// Values of all nodes at given variables. It serves set-up: one place at a time.
    std::vector<double> values(const std::array<double, variables>& at) const;

private:
    using Key = std::tuple<Op, std::array<int, 3>, std::uint64_t, int>;
    int put(Node node);
    int look_up(Op op, int table, int a);
    double apply(const Node& node, double a, double b, double c) const;
    /// Derivative of node `self`, which is n, from the derivatives da, db and dc of its operands.
    int chain_rule(int self, const Node& n, int da, int db, int dc, Variable by);

    std::vector<FormulaTable> tables_;
    std::vector<Node> nodes_;
    std::map<Key, int> known_;
};

} // namespace skein
