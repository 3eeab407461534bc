#include "formula/program.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <functional>

namespace skein {

namespace {

/// `input_of`: number of the input that a node is to this list, -1 where it is worked out in it.
std::optional<InstructionList> list_of(const Graph& graph, std::span<const int> outputs,
                                       const std::function<int(int)>& input_of) {
    InstructionList list;
    const auto count = graph.nodes().size();
    std::vector<int> uses(count, 0), last_use(count, -1), source(count, -1);
    const int forever = static_cast<int>(count);
    for (const int o : outputs) {
        ++nth(uses, o);
        nth(last_use, o) = forever;
    }
    // Whether the list works a node out.
    const auto made = [&](std::size_t i) {
        return uses[i] > 0 && graph.nodes()[i].op != Op::constant && input_of(static_cast<int>(i)) < 0;
    };
    for (std::size_t i = count; i-- > 0;)
        if (made(i))
            for (const int operand : graph.nodes()[i].of)
                if (operand >= 0) ++nth(uses, operand);
    // Of two in a row of + - * /, the first of no other use, one instruction is made: `inner` of each node, and the
    // node it is in. The negative of x counts as -0 - x, which has its bits.
    std::vector<int> inner(count, -1), within(count, -1);
    for (std::size_t i = 0; i < count; ++i) {
        if (!made(i)) continue;
        const Graph::Node& n = graph.nodes()[i];
        for (const int o : n.of) {
            const auto k = static_cast<std::size_t>(o);
            if (o >= 0 && inner[i] < 0 && (is_arithmetic(n.op) || n.op == Op::negative) && is_arithmetic(graph[o].op) &&
                made(k) && uses[k] == 1 && inner[k] < 0) {
                inner[i] = o;
                within[k] = static_cast<int>(i);
            }
        }
    }
    for (std::size_t i = 0; i < count; ++i)
        if (made(i))
            for (const int operand : graph.nodes()[i].of)
                if (operand >= 0) {
                    int& last = nth(last_use, operand);
                    last = std::max(last, within[i] >= 0 ? within[i] : static_cast<int>(i));
                }
    std::vector<bool> taken;
    // Registers now, constants from 1000000 and inputs from 2000000 on, until their numbers are known.
    constexpr int constant_base = 1000000, input_base = 2000000;
    for (std::size_t i = 0; i < count; ++i) {
        if (uses[i] == 0) continue;
        const Graph::Node& n = graph.nodes()[i];
        if (n.op == Op::constant) {
            source[i] = constant_base + static_cast<int>(list.constants.size());
            list.constants.push_back(n.number);
            continue;
        }
        if (const int input = input_of(static_cast<int>(i)); input >= 0) {
            source[i] = input_base + static_cast<int>(list.inputs.size());
            list.inputs.push_back(input);
            continue;
        }
        if (within[i] >= 0) continue;
        const auto operand = [&](const Graph::Node& of, std::size_t k) {
            return of.of[k] >= 0 ? nth(source, of.of[k]) : -1;
        };
        // An operand's register may take the result: places are worked out one by one.
        const auto release = [&](const Graph::Node& of) {
            for (const int o : of.of)
                if (o >= 0 && nth(last_use, o) == static_cast<int>(i) && nth(source, o) >= 0 &&
                    nth(source, o) < constant_base)
                    nth(taken, nth(source, o)) = false;
        };
        Instruction in{n.op, n.index, -1, operand(n, 0), operand(n, 1), operand(n, 2)};
        if (inner[i] >= 0) {
            const Graph::Node& first = graph[inner[i]];
            in = {first.op, 0, -1, operand(first, 0), operand(first, 1), -1, n.op, n.of[1] == inner[i]};
            if (n.op == Op::negative) {
                in.c = constant_base + static_cast<int>(list.constants.size());
                in.then = Op::subtract;
                in.reversed = true;
                list.constants.push_back(-0.0);
            } else {
                in.c = operand(n, in.reversed ? 0 : 1);
            }
            release(first);
        }
        release(n);
        const auto free = std::find(taken.begin(), taken.end(), false);
        in.to = static_cast<int>(free - taken.begin());
        if (free == taken.end()) taken.push_back(true);
        else *free = true;
        source[i] = in.to;
        list.code.push_back(in);
    }
    list.registers = static_cast<int>(taken.size());
    if (list.registers > InstructionList::most_registers || list.sources() > InstructionList::most_sources)
        return std::nullopt;
    const auto settle = [&](int& s) {
        if (s >= input_base) s = list.first_input() + s - input_base;
        else if (s >= constant_base) s = list.registers + s - constant_base;
    };
    for (Instruction& in : list.code) {
        settle(in.a);
        settle(in.b);
        settle(in.c);
    }
    for (const int o : outputs) {
        list.outputs.push_back(nth(source, o));
        settle(list.outputs.back());
    }
    return list;
}

} // namespace

bool FormulaProgram::uses(Variable v) const {
    const auto in = [v](const InstructionList& list) {
        return std::find(list.inputs.begin(), list.inputs.end(), static_cast<int>(v)) != list.inputs.end();
    };
    return in(time) || in(place) || in(state);
}

double FormulaProgram::predicted_ns() const {
    const auto of = [](Op op) {
        switch (op) {
        case Op::divide:
        case Op::root:
            return 0.6;
        case Op::sine:
        case Op::cosine:
        case Op::exponential:
            return 0.8;
        case Op::logarithm:
        case Op::hyperbolic_tangent:
        case Op::arc_tangent:
            return 1.6;
        case Op::power:
            return 4.0;
        case Op::tabulated:
        case Op::tabulated_slope:
            return 12.0;
        default:
            return 0.2;
        }
    };
    double sum = 0;
    for (const Instruction& in : state.code) sum += of(in.op);
    return sum;
}

std::optional<FormulaProgram> compiled(const Graph& graph, std::span<const int> outputs) {
    FormulaProgram program{.tables = graph.tables()};
    std::vector<int> of_time, of_place; // nodes that are inputs of the last list
    const auto number_in = [](std::vector<int>& list, int node) {
        const auto found = std::find(list.begin(), list.end(), node);
        if (found != list.end()) return static_cast<int>(found - list.begin());
        list.push_back(node);
        return static_cast<int>(list.size()) - 1;
    };
    const auto state_input = [&](int node) {
        const Graph::Node& n = graph[node];
        if (n.changes == with_time) return time_base + number_in(of_time, node);
        if (n.changes == with_place) return place_base + number_in(of_place, node);
        return n.op == Op::variable ? n.index : -1;
    };
    const auto variable_input = [&](int node) { return graph[node].op == Op::variable ? graph[node].index : -1; };
    for (const int o : outputs) program.changes |= graph[o].changes;
    // Called of nodes in turn that are needed, so that what is numbered is what is used; but asked twice of each, once
    // from above.
    std::optional<InstructionList> state = list_of(graph, outputs, state_input);
    if (!state) return std::nullopt;
    program.state = std::move(*state);
    std::optional<InstructionList> time = list_of(graph, of_time, variable_input),
                                   place = list_of(graph, of_place, variable_input);
    if (!time || !place) return std::nullopt;
    program.time = std::move(*time);
    program.place = std::move(*place);
    return program;
}

} // namespace skein
