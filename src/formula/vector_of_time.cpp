#include "formula/vector_of_time.hpp"

#include "formula/evaluate.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

#include <fmt/format.h>

namespace skein {

VectorOfTime::VectorOfTime(const FormulaScope& scope, const std::vector<std::string>& texts, std::string_view unit,
                           bool rods)
    : graph_(scope.tables) {
    if (!skein::faults(scope).empty()) return;
    if (texts.size() != 3) {
        faults_.push_back({{}, fmt::format("a vector needs 3 formulas, not {}", texts.size())});
        return;
    }
    std::vector<int> value;
    for (std::size_t i = 0; i < texts.size(); ++i) {
        const int number = static_cast<int>(i);
        const auto read = read_formula(graph_, scope, texts[i], number, unit, faults_);
        if (!read) continue;
        value.push_back(read->node);
        constexpr std::array allowed{Variable::t, Variable::rod};
        if (graph_.varies_beyond(read->node, std::span(allowed).first(rods ? 2 : 1)))
            faults_.push_back({{0, texts[i].size(), number},
                               rods ? "it may change with t and rod alone"
                                    : "it may change with t alone: it is the same for all rods of the group"});
    }
    if (!faults_.empty()) return;
    value_ = value;
    for (const int node : value_) rate_.push_back(graph_.derivative(node, Variable::t));
    if (std::any_of(value_.begin(), value_.end(), [&](int i) { return (graph_[i].changes & with_place) != 0; })) {
        std::vector<int> outputs = value_;
        outputs.insert(outputs.end(), rate_.begin(), rate_.end());
        by_rod_ = compiled(graph_, outputs);
        if (!by_rod_) faults_.push_back({{}, "it needs too many values at once: use fewer terms"});
    }
    try_times(scope.tried());
    for (std::size_t i = 0; i < faults_.size(); ++i)
        faults_[i].part.length = nth(texts, faults_[i].part.formula).size();
}

void VectorOfTime::try_times(const TimeSpan& span) {
    constexpr int times = 64;
    for (int n = 0; n <= times && !span.empty(); ++n) {
        const double t = span.at(static_cast<double>(n) / times);
        const Point p = (*this)(t);
        const std::array<double, 3> value = {p.value.x, p.value.y, p.value.z}, rate = {p.rate.x, p.rate.y, p.rate.z};
        for (std::size_t i = 0; i < 3; ++i) {
            const bool of_rods = (graph_[value_[i]].changes & with_place) != 0; // no rod may have this number
            if (of_rods || (std::isfinite(value[i]) && std::isfinite(rate[i]))) continue;
            faults_.push_back(
                {{0, 0, static_cast<int>(i)},
                 fmt::format("{} is not finite at t = {:.6g} s", std::isfinite(value[i]) ? "its rate" : "it", t)});
            return;
        }
        if (!(span.end > span.begin)) return;
    }
}

VectorOfTime::Point VectorOfTime::operator()(double time, double rod) const {
    if (value_.empty()) return {};
    std::array<double, variables> at{};
    nth(at, Variable::t) = time;
    nth(at, Variable::rod) = rod;
    const std::vector<double> all = graph_.values(at);
    const auto vector = [&](const std::vector<int>& nodes) {
        const auto of = [&](std::size_t i) { return nth(all, nodes[i]); };
        return Vec3d{of(0), of(1), of(2)};
    };
    return {vector(value_), vector(rate_)};
}

namespace {

/// Runs the lists of a program for rods side by side.
class RodStrip {
public:
    static constexpr int most = strip<1>;

    explicit RodStrip(const FormulaProgram& program) : program_(program), registers_(new StripRegisters<1>) {}

    /// Sets the rods, at most `most`.
    void place(std::span<const double> rods) {
        count_ = static_cast<int>(rods.size());
        rods_.assign(rods.begin(), rods.end());
        places_ = run(program_.place, count_, [&](int) -> Strided<1> { return {rods_.data(), 1}; });
    }
    /// Outputs at a time, each for all rods.
    std::vector<std::vector<Pack<1>>> at(double time) {
        const Pack<1> now(time);
        const auto times = run(program_.time, 1, [&](int) -> Strided<1> { return {&now, 0}; });
        return run(program_.state, count_, [&](int input) -> Strided<1> {
            return input >= place_base ? Strided<1>{nth(places_, input - place_base).data(), 1}
                                       : Strided<1>{nth(times, input - time_base).data(), 0};
        });
    }

private:
    template <class Input>
    std::vector<std::vector<Pack<1>>> run(const InstructionList& list, int count, Input&& input) {
        std::array<Strided<1>, InstructionList::most_sources> source;
        std::array<Pack<1>, InstructionList::most_sources> same;
        spread_constants<1>(list, same.data(), source.data());
        for (std::size_t i = 0; i < list.inputs.size(); ++i)
            nth(source, list.first_input() + static_cast<int>(i)) = input(list.inputs[i]);
        evaluate<1>(list, program_.tables, source.data(), *registers_, count);
        std::vector<std::vector<Pack<1>>> outputs;
        for (const int output : list.outputs) {
            std::vector<Pack<1>>& of = outputs.emplace_back();
            for (int i = 0; i < count; ++i) of.push_back(nth(source, output)[i]);
        }
        return outputs;
    }

    const FormulaProgram& program_;
    std::unique_ptr<StripRegisters<1>> registers_;
    int count_ = 0;
    std::vector<Pack<1>> rods_;
    std::vector<std::vector<Pack<1>>> places_;
};

} // namespace

VectorOfTime::Tried VectorOfTime::try_rods(double duration, int times, std::span<const double> rods) const {
    Tried found;
    if (!by_rod_) return found;
    std::array<double, 3> largest{};
    RodStrip strip(*by_rod_);
    for (std::size_t first = 0; first < rods.size() && !found.not_finite; first += RodStrip::most) {
        const auto some = rods.subspan(first, std::min<std::size_t>(RodStrip::most, rods.size() - first));
        strip.place(some);
        for (int n = 0; n <= times; ++n) {
            const auto outputs = strip.at(duration * n / times);
            for (std::size_t o = 0; o < outputs.size(); ++o)
                for (std::size_t i = 0; i < some.size(); ++i) {
                    const double x = std::abs(outputs[o][i][0]);
                    if (!std::isfinite(x)) found.not_finite = std::min(found.not_finite.value_or(some[i]), some[i]);
                    else if (o < largest.size()) largest[o] = std::max(largest[o], x);
                }
        }
    }
    found.largest = {largest[0], largest[1], largest[2]};
    return found;
}

bool VectorOfTime::vanishes(std::size_t i) const { return value_.empty() || graph_.number(value_[i]) == 0; }

} // namespace skein
