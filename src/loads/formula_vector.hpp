// Formulas of a load, evaluated over the places of a tile. Values that change with time alone are computed once a step,
// values of places alone once a run.
#pragma once

#include "formula/evaluate.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/mapping.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <vector>

namespace skein {

/// Several formulas with their values for a batch of steps.
struct FormulaVector {
    bool given = false;
    FormulaProgram program;
    std::vector<double> of_time; ///< values of program.time, by value and slot of the batch
    /// by slot of the batch: the first three formulas, where same_everywhere()
    std::array<Vec3d, Clock::largest_batch> uniform{};

    void prepare(std::span<const Step> steps);
    /// True where nothing changes from place to place.
    bool same_everywhere() const { return (program.changes & ~with_time) == 0; }
    /// True where values of places come from tables, which a program may change (skein/run.hpp).
    bool has_tables_of_places() const {
        return std::any_of(program.place.code.begin(), program.place.code.end(), [](const Instruction& in) {
            return in.op == Op::tabulated || in.op == Op::tabulated_slope;
        });
    }
    double time_value(int i, int slot) const { return nth(of_time, i * Clock::largest_batch + slot); }

private:
    struct BySlot {
        const double* first;
        std::ptrdiff_t step; ///< 0 for a constant
        double operator[](int slot) const { return first[slot * step]; }
    };
    /// Formula i, the same everywhere, at the steps of the batch.
    BySlot by_slot(std::size_t i) const {
        const InstructionList& list = program.state;
        const int from = list.outputs[i];
        if (from < list.first_input()) return {&nth(list.constants, from - list.registers), 0};
        const int value = nth(list.inputs, from - list.first_input()) - time_base;
        return {&nth(of_time, value * Clock::largest_batch), 1};
    }
    void run_in_time(std::span<const Step> steps);
};

/// Places along a rod: arc lengths and start positions of its nodes, or of the middles of its elements.
struct FormulaPlaces {
    std::vector<double> s;
    std::vector<Vec3d> start;
    double length = 0, rod = 0;

    FormulaPlaces(const RodGroup& group, std::int64_t index, bool middles, bool with_start);
    double value(Variable v, std::size_t slot) const;
};

/// Values of program.place for a tile, by value and row; one row where all are equal.
template <int W> using PlaceValues = std::vector<AlignedVector<Pack<W>>>;

template <int W> PlaceValues<W> place_values(const FormulaVector& of, const RodTile<W>& rod, bool middles) {
    const InstructionList& list = of.program.place;
    const auto is_of_rod = [](int input) {
        return input == static_cast<int>(Variable::rod) || input == static_cast<int>(Variable::length);
    };
    const bool by_rod = std::all_of(list.inputs.begin(), list.inputs.end(), is_of_rod); // one row
    const int rows = by_rod ? 1 : middles ? rod.n : rod.n + 1;
    PlaceValues<W> values(list.outputs.size()), inputs(list.inputs.size());
    if (values.empty()) return values;
    for (auto& input : inputs) input.resize(to_index(rows));
    const bool with_start =
        of.program.uses(Variable::start_x) || of.program.uses(Variable::start_y) || of.program.uses(Variable::start_z);
    for (int l = 0; by_rod && l < lanes_of<W>; ++l)
        for (std::size_t k = 0; k < inputs.size(); ++k)
            inputs[k].front().set(l, list.inputs[k] == static_cast<int>(Variable::rod)
                                         ? static_cast<double>(rod.index_of(l))
                                         : rod.group_of(l).spec().shape.length);
    for (int l = 0; !by_rod && l < lanes_of<W>; ++l) {
        const FormulaPlaces along(rod.group_of(l), rod.index_of(l), middles, with_start);
        for (int i = 0; i < rows; ++i) {
            const int slot = rod.strands ? std::max(0, rod.strands->slot(l, i)) : i;
            for (std::size_t k = 0; k < inputs.size(); ++k)
                nth(inputs[k], i)
                    .set(l, along.value(static_cast<Variable>(list.inputs[k]),
                                        std::min(static_cast<std::size_t>(slot), along.s.size() - 1)));
        }
    }
    for (auto& value : values) value.resize(to_index(rows));
    StripRegisters<W> registers;
    Strided<W> source[InstructionList::most_sources];
    Pack<W> same[InstructionList::most_sources];
    spread_constants<W>(list, same, source);
    for (int first = 0; first < rows; first += strip<W>) {
        const int count = std::min(strip<W>, rows - first);
        for (std::size_t k = 0; k < inputs.size(); ++k)
            source[to_index(list.first_input()) + k] = Strided<W>{inputs[k].data(), 1}.from(first);
        evaluate<W>(list, of.program.tables, source, registers, count);
        for (std::size_t o = 0; o < values.size(); ++o)
            for (int i = 0; i < count; ++i) nth(values[o], first + i) = source[list.outputs[o]][i];
    }
    for (auto& value : values) { // a single row where all are equal
        bool same_bits = true;
        for (const Pack<W>& p : value) same_bits = same_bits && std::memcmp(&p, value.data(), sizeof p) == 0;
        if (same_bits) value.resize(1);
    }
    return values;
}

/// Formulas at one step, strip by strip of a tile.
template <int W> class FormulaRun {
public:
    using P = Pack<W>;

    FormulaRun(const FormulaVector& of, const PlaceValues<W>& places, int slot)
        : list_(of.program.state), tables_(of.program.tables), places_(places) {
        for (std::size_t i = 0; i < list_.constants.size(); ++i)
            spread(list_.registers + static_cast<int>(i), list_.constants[i]);
        for (std::size_t i = 0; i < list_.inputs.size(); ++i)
            if (const int input = list_.inputs[i]; input >= time_base && input < place_base)
                spread(list_.first_input() + static_cast<int>(i), of.time_value(input - time_base, slot));
    }

    /// Number of places per strip for so many places: all of them where nothing is computed.
    int strip_of(int places) const {
        const bool no_state =
            std::none_of(list_.inputs.begin(), list_.inputs.end(), [](int input) { return input < time_base; });
        if (list_.code.empty() && no_state) return places;
        const int strips = std::max(1, (places + strip<W> - 1) / strip<W>);
        return (places + strips - 1) / strips; // strips of one length, so that the ends of loops can be predicted
    }
    /// Evaluates nodes `first` to `first + count - 1`; count at most strip_of().
    void at_nodes(const RodTile<W>& rod, int first, int count) {
        constexpr int slot_packs = static_cast<int>(sizeof(Slot<W>) / sizeof(P));
        run(first, count, [&](int variable) {
            return Strided<W>{reinterpret_cast<const P*>(rod.slot + first) + variable, slot_packs};
        });
    }
    /// Evaluates the middles of elements.
    template <class Map> void at_middles(const RodTile<W>& rod, int first, int count) {
        run(first, count, [&](int variable) {
            P* to = middle_[variable];
            const auto mean = [&](auto component) {
                for (int k = 0; k < count; ++k) to[k] = P(0.5) * (component(first + k) + component(first + k + 1));
            };
            const auto part = [axis = variable % 3](const Vec3<P>& v) {
                return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
            };
            if (variable < static_cast<int>(Variable::vx)) {
                mean([&](int k) { return part(rod.slot[k].position); });
            } else {
                const Vec3<P> last = last_node_value<Map>(rod, rod.slot[0].velocity, rod.slot[rod.n].velocity);
                mean([&](int k) { return part(k < rod.n ? rod.slot[k].velocity : last); });
            }
            return Strided<W>{to, 1};
        });
    }

    /// Values of formula i from place to place of the strip.
    const Strided<W>& operator[](int i) const { return source_[nth(list_.outputs, i)]; }

private:
    /// Sets a value for all places of the step.
    void spread(int to, double value) {
        same_[to] = P(value);
        source_[to] = {&same_[to], 0};
    }
    template <class StateOf> void run(int first, int count, StateOf state_of) {
        for (std::size_t i = 0; i < list_.inputs.size(); ++i) {
            Strided<W>& source = source_[to_index(list_.first_input()) + i];
            if (const int input = list_.inputs[i]; input < time_base) {
                source = state_of(input);
            } else if (input >= place_base) {
                const auto& values = nth(places_, input - place_base);
                source = Strided<W>{values.data(), values.size() > 1}.from(first);
            }
        }
        evaluate<W>(list_, tables_, source_, registers_, count);
    }

    const InstructionList& list_;
    std::span<const FormulaTable> tables_;
    const PlaceValues<W>& places_;
    Strided<W> source_[InstructionList::most_sources];
    P same_[InstructionList::most_sources], middle_[6][strip<W>];
    StripRegisters<W> registers_;
};

inline void FormulaVector::prepare(std::span<const Step> steps) {
    run_in_time(steps);
    if (!given || !same_everywhere()) return;
    const BySlot x = by_slot(0), y = by_slot(1), z = by_slot(2);
    for (const Step& step : steps) nth(uniform, step.slot) = {x[step.slot], y[step.slot], z[step.slot]};
}

/// Steps of the batch are evaluated side by side, as many as a register holds.
inline void FormulaVector::run_in_time(std::span<const Step> steps) {
    const InstructionList& list = program.time;
    if (list.outputs.empty()) return;
    of_time.resize(list.outputs.size() * Clock::largest_batch);
    constexpr int W = native_lanes;
    static_assert(Clock::largest_batch % W == 0 && Clock::largest_batch / W <= strip<W>);
    StripRegisters<W> registers;
    Pack<W> time[Clock::largest_batch / W];
    Strided<W> source[InstructionList::most_sources];
    Pack<W> same[InstructionList::most_sources];
    const int count = static_cast<int>(steps.size()), packs = (count + W - 1) / W;
    double number[Clock::largest_batch];
    for (int i = 0; i < packs * W; ++i) number[i] = nth(steps, std::min(i, count - 1)).time;
    std::memcpy(time, number, to_index(packs) * sizeof time[0]);
    spread_constants<W>(list, same, source);
    for (std::size_t i = 0; i < list.inputs.size(); ++i) source[to_index(list.first_input()) + i] = {time, 1};
    evaluate<W>(list, program.tables, source, registers, packs);
    for (std::size_t o = 0; o < list.outputs.size(); ++o) {
        const Strided<W>& value = source[list.outputs[o]];
        for (int i = 0; i < packs; ++i) {
            const Pack<W> some = value[i];
            std::memcpy(number + i * W, &some, sizeof some);
        }
        double* to = of_time.data() + o * Clock::largest_batch;
        for (int i = 0; i < count; ++i) to[nth(steps, i).slot] = number[i];
    }
}

} // namespace skein
