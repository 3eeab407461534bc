#include "formula/program.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <functional>

namespace skein {

namespace {

/// Translates the nodes of a graph that some outputs need into one list of instructions.
class ListBuilder {
public:
    /// `input_of` gives the number of the input that a node is to this list, or -1 where the list computes the node.
    ListBuilder(const Graph& graph, std::span<const int> outputs, const std::function<int(int)>& input_of)
        : graph_(graph), outputs_(outputs), input_of_(input_of), count_(graph.nodes().size()), uses_(count_, 0),
          last_use_(count_, -1), inner_(count_, -1), within_(count_, -1), source_(count_, -1) {}

    /// Absent where the list needs too many registers or sources.
    std::optional<InstructionList> build() {
        count_uses();
        fuse_pairs();
        find_last_uses();
        for (std::size_t i = 0; i < count_; ++i) {
            if (uses_[i] == 0 || take_constant_or_input(i) || within_[i] >= 0) continue;
            emit(i);
        }
        list_.registers = static_cast<int>(taken_.size());
        if (list_.registers > InstructionList::most_registers || list_.sources() > InstructionList::most_sources)
            return std::nullopt;
        number_sources();
        return std::move(list_);
    }

private:
    // Sources are registers below `constant_base`, constants below `input_base`, and inputs, until all are counted.
    static constexpr int constant_base = 1000000, input_base = 2000000;

    const Graph::Node& node(std::size_t i) const { return graph_.nodes()[i]; }

    /// True where an instruction of the list computes the node.
    bool computed(std::size_t i) const {
        return uses_[i] > 0 && node(i).op != Op::constant && input_of_(static_cast<int>(i)) < 0;
    }

    template <class F> void for_operands_of_computed(F&& f) const {
        for (std::size_t i = count_; i-- > 0;)
            if (computed(i))
                for (const int operand : node(i).of)
                    if (operand >= 0) f(i, operand);
    }

    void count_uses() {
        for (const int o : outputs_) {
            ++nth(uses_, o);
            nth(last_use_, o) = static_cast<int>(count_); // outputs stay to the end
        }
        for_operands_of_computed([&](std::size_t, int operand) { ++nth(uses_, operand); });
    }

    /// Finds pairs of + - * /, the first of which has no other use: both become one instruction. The negative of x
    /// counts as -0 - x, which has the same bits.
    void fuse_pairs() {
        for (std::size_t i = 0; i < count_; ++i) {
            if (!computed(i) || !(is_arithmetic(node(i).op) || node(i).op == Op::negative)) continue;
            for (const int o : node(i).of) {
                if (o < 0 || inner_[i] >= 0) continue;
                const std::size_t k = to_index(o);
                if (!is_arithmetic(node(k).op) || !computed(k) || uses_[k] != 1 || inner_[k] >= 0) continue;
                inner_[i] = o;
                within_[k] = static_cast<int>(i);
            }
        }
    }

    void find_last_uses() {
        for_operands_of_computed([&](std::size_t i, int operand) {
            int& last = nth(last_use_, operand);
            last = std::max(last, within_[i] >= 0 ? within_[i] : static_cast<int>(i));
        });
    }

    int add_constant(double value) {
        list_.constants.push_back(value);
        return constant_base + static_cast<int>(list_.constants.size()) - 1;
    }

    bool take_constant_or_input(std::size_t i) {
        if (node(i).op == Op::constant) {
            source_[i] = add_constant(node(i).number);
            return true;
        }
        const int input = input_of_(static_cast<int>(i));
        if (input < 0) return false;
        source_[i] = input_base + static_cast<int>(list_.inputs.size());
        list_.inputs.push_back(input);
        return true;
    }

    int operand(const Graph::Node& n, std::size_t k) const { return n.of[k] >= 0 ? nth(source_, n.of[k]) : -1; }

    void emit(std::size_t i) {
        const Graph::Node& n = node(i);
        Instruction in{n.op, n.index, -1, operand(n, 0), operand(n, 1), operand(n, 2)};
        if (inner_[i] >= 0) {
            const Graph::Node& first = graph_[inner_[i]];
            in = {first.op, 0, -1, operand(first, 0), operand(first, 1), -1, n.op, n.of[1] == inner_[i]};
            if (n.op == Op::negative) {
                in.c = add_constant(-0.0);
                in.then = Op::subtract;
                in.reversed = true;
            } else {
                in.c = operand(n, in.reversed ? 0 : 1);
            }
            release(first, i);
        }
        release(n, i);
        in.to = take_register();
        source_[i] = in.to;
        list_.code.push_back(in);
    }

    /// Frees the registers of operands that node i uses last. The result may take one of them, as places are computed
    /// one by one.
    void release(const Graph::Node& n, std::size_t i) {
        for (const int o : n.of)
            if (o >= 0 && nth(last_use_, o) == static_cast<int>(i) && nth(source_, o) >= 0 &&
                nth(source_, o) < constant_base)
                nth(taken_, nth(source_, o)) = false;
    }

    int take_register() {
        const auto free = std::find(taken_.begin(), taken_.end(), false);
        const auto number = static_cast<int>(free - taken_.begin());
        if (free == taken_.end()) taken_.push_back(true);
        else *free = true;
        return number;
    }

    void number_sources() {
        const auto number = [&](int& s) {
            if (s >= input_base) s = list_.first_input() + s - input_base;
            else if (s >= constant_base) s = list_.registers + s - constant_base;
        };
        for (Instruction& in : list_.code) {
            number(in.a);
            number(in.b);
            number(in.c);
        }
        for (const int o : outputs_) {
            list_.outputs.push_back(nth(source_, o));
            number(list_.outputs.back());
        }
    }

    const Graph& graph_;
    std::span<const int> outputs_;
    const std::function<int(int)>& input_of_;
    std::size_t count_;
    std::vector<int> uses_, last_use_; ///< numbers by node
    std::vector<int> inner_, within_;  ///< by node: first node of a fused pair, and node that it is fused into
    std::vector<int> source_;          ///< number of the source, by node
    std::vector<bool> taken_;          ///< registers in use
    InstructionList list_;
};

std::optional<InstructionList> list_of(const Graph& graph, std::span<const int> outputs,
                                       const std::function<int(int)>& input_of) {
    return ListBuilder(graph, outputs, input_of).build();
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
    // `state_input` numbers the inputs in the order of its calls: the list asks first for the nodes that it needs, from
    // the last one down.
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
