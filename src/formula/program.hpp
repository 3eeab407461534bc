// A graph made ready to run: what changes with time alone is worked out once a step, what belongs to places alone once
// a run, and the rest place by place. Each of the three is a list of instructions over blocks of values
// (formula/evaluate.hpp), so that telling which operation comes next costs nothing beside doing it.
#pragma once

#include "formula/graph.hpp"

#include <optional>
#include <vector>

namespace skein {

struct Instruction {
    Op op;
    int table; ///< of `tabulated` and its slope
    int to;    ///< register
    int a, b, c;
    std::optional<Op> then{}; ///< `then` of (a op b) and c, in one
    bool reversed = false;    ///< `then` of c and (a op b)
};

/// Instructions read and write sources by number: first registers, then constants, then inputs.
struct InstructionList {
    static constexpr int most_registers = 32, most_sources = 128;

    std::vector<Instruction> code;
    int registers = 0;
    std::vector<double> constants;
    std::vector<int> inputs;  ///< variables, or values of lists that were run before
    std::vector<int> outputs; ///< sources
    int first_input() const { return registers + static_cast<int>(constants.size()); }
    int sources() const { return first_input() + static_cast<int>(inputs.size()); }
};

/// Inputs of FormulaProgram::state: a variable v is v, value i of `time` or of `place` is time_base + i or place_base +
/// i.
inline constexpr int time_base = 1000, place_base = 2000;

struct FormulaProgram {
    InstructionList time, place, state;
    std::vector<FormulaTable> tables;
    unsigned changes = 0; ///< of all outputs
    bool uses(Variable v) const;
    /// Time that the state's list takes, ns a place with eight lanes on one core of a machine of 2023.
    double predicted_ns() const;
};

/// Of the values at these nodes. Absent where there are too many values at once.
std::optional<FormulaProgram> compiled(const Graph& graph, std::span<const int> outputs);

} // namespace skein
