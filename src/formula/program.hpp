// A graph made ready to run. Values that change with time alone are computed once a step, values of places alone once a
// run, and the rest place by place. Each of the three is a list of instructions over blocks of values
// (formula/evaluate.hpp), so that the choice of the next operation costs little beside the operation.
#pragma once

#include "formula/graph.hpp"

#include <optional>
#include <vector>

namespace skein {

struct Instruction {
    Op op;
    int table; ///< number of the table of `tabulated` and its slope
    int to;    ///< register
    int a, b, c;
    std::optional<Op> then{}; ///< second operation, on (a op b) and c, fused with the first
    bool reversed = false;    ///< true for `then` on c and (a op b)
};

/// Sources of instructions are numbered: registers first, then constants, then inputs.
struct InstructionList {
    static constexpr int most_registers = 32, most_sources = 128;

    std::vector<Instruction> code;
    int registers = 0;
    std::vector<double> constants;
    std::vector<int> inputs;  ///< variables, or values of earlier lists
    std::vector<int> outputs; ///< numbers of sources
    int first_input() const { return registers + static_cast<int>(constants.size()); }
    int sources() const { return first_input() + static_cast<int>(inputs.size()); }
};

/// Numbering of the inputs of FormulaProgram::state: a variable v is v, value i of `time` time_base + i, value i of
/// `place` place_base + i.
inline constexpr int time_base = 1000, place_base = 2000;

struct FormulaProgram {
    InstructionList time, place, state;
    std::vector<FormulaTable> tables;
    unsigned changes = 0; ///< dependences of all outputs
    bool uses(Variable v) const;
    /// Time of the state's list, ns a place with eight lanes on one core of a machine of 2023.
    double predicted_ns() const;
};

/// Program for the values at these nodes. Returns nothing where too many values are needed at once.
std::optional<FormulaProgram> compiled(const Graph& graph, std::span<const int> outputs);

} // namespace skein
