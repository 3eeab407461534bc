// Formulas as a graph: every value once, however often it is written; constants worked out. Operands come before what
// uses them.
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

/// Where in the text of a formula a value is written, in bytes.
struct Part {
    std::size_t begin = 0, length = 0;
    int formula = -1; ///< of several; -1: it is not written, as of a derivative
};

class Graph {
public:
    struct Node {
        Op op = Op::constant;
        std::array<int, 3> of{-1, -1, -1};
        double number = 0; ///< of a constant
        int index = 0;     ///< variable or table
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
    /// a^n for a whole number.
    int whole_power(int a, int n);

    /// Value of a constant; absent of others.
    std::optional<double> number(int i) const {
        return (*this)[i].op == Op::constant ? std::optional((*this)[i].number) : std::nullopt;
    }
    /// Whether a value depends on a variable that is none of these.
    bool varies_beyond(int node, std::span<const Variable> allowed) const;
    void mark(int i, const Part& part) {
        if (Part& p = nth(nodes_, i).part; p.formula < 0) p = part;
    }

    /// d(node)/d(variable).
    int derivative(int node, Variable by);

    /// Values of all nodes at given variables. For set-up: one place at a time.
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
