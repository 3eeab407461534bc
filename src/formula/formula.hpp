// Text to graph: the language of formulas, its names and its units.
//   3.1e-2  k  gust(t)  + - * / ^  < <= > >= == !=  if(condition, a, b)  sin cos tan exp log sqrt abs floor sign step
//   tanh atan min max atan2 hypot mod ramp  pi e
#pragma once

#include "formula/graph.hpp"
#include "skein/core/objections.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// A fault of a formula, and its place in the text.
struct FormulaFault {
    Part part;
    std::string message;
};

/// A formula that was read: its value in the graph, and its unit where all of its numbers have one.
struct FormulaValue {
    int node = -1;
    std::optional<Unit> unit;
};

/// Reads formula number `number` of a graph, in the unit expected. Returns nothing where there are faults. Names that
/// have no meaning at a place (`allowed`) are unknown there.
std::optional<FormulaValue> read_formula(Graph& graph, const FormulaScope& scope, std::string_view text, int number,
                                         std::string_view expected, std::vector<FormulaFault>& faults);

/// Adds the faults of a vector of formulas below `key` to the objections.
void add_faults(const std::string& key, std::span<const FormulaFault> faults, Objections& objections);

/// All names that a formula may hold.
std::vector<std::string_view> known_names(const FormulaScope& scope);

} // namespace skein
