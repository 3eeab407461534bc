#include "fluid/start_velocity.hpp"

#include "formula/evaluate.hpp"
#include "skein/core/index.hpp"

#include <algorithm>

namespace skein {

namespace {

constexpr Variable places[] = {Variable::x, Variable::y, Variable::z};

} // namespace

StartVelocity::StartVelocity(const std::vector<std::string>& texts, const FormulaScope& names) {
    if (!skein::faults(names).empty()) return; // the scope reports them
    if (texts.size() != 3) {
        faults_.push_back({{}, "a vector needs 3 formulas, not " + std::to_string(texts.size())});
        return;
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const int number = static_cast<int>(i);
        Graph graph(names.tables);
        const auto read = read_formula(graph, names, texts[i], number, "m/s", faults_);
        if (!read) continue;
        const Part whole{0, texts[i].size(), number};
        if (graph.varies_beyond(read->node, places))
            faults_.push_back({whole, "it may name 'x', 'y', 'z', constants, tables and functions alone"});
        else if (const auto program = compiled(graph, std::span(&read->node, 1))) program_[i] = *program;
        else faults_.push_back({whole, "it has too many values at once"});
    }
}

void StartVelocity::operator()(int component, const Vec3d& first, double spacing, std::span<double> row) const {
    constexpr int W = 2;
    const FormulaProgram& program = nth(program_, component);
    const InstructionList& list = program.state;
    if (list.outputs.empty()) return;
    StripRegisters<W> registers;
    Strided<W> source[InstructionList::most_sources];
    Pack<W> constant[InstructionList::most_sources], x[strip<W>];
    const Pack<W> y(first.y), z(first.z);
    for (std::size_t c = 0; c < list.constants.size(); ++c) {
        constant[c] = Pack<W>(list.constants[c]);
        source[to_index(list.registers) + c] = {&constant[c], 0};
    }
    for (std::size_t i = 0; i < list.inputs.size(); ++i) {
        const auto variable = static_cast<Variable>(list.inputs[i]);
        source[to_index(list.first_input()) + i] =
            variable == Variable::x ? Strided<W>{x, 1} : Strided<W>{variable == Variable::y ? &y : &z, 0};
    }
    for (std::size_t begin = 0; begin < row.size(); begin += W * strip<W>) {
        const std::size_t values = std::min<std::size_t>(W * strip<W>, row.size() - begin);
        const int packs = static_cast<int>((values + W - 1) / W);
        for (int p = 0; p < packs; ++p)
            for (int l = 0; l < W; ++l)
                x[p].set(l, first.x + spacing * static_cast<double>(begin + to_index(W * p + l)));
        evaluate<W>(list, program.tables, source, registers, packs);
        const Strided<W>& out = nth(source, list.outputs.front());
        for (std::size_t i = 0; i < values; ++i) row[begin + i] = out[static_cast<int>(i / W)][static_cast<int>(i % W)];
    }
}

} // namespace skein
