#include "formula/vector_of_time.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
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
            if (std::isfinite(value[i]) && std::isfinite(rate[i])) continue;
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

bool VectorOfTime::vanishes(std::size_t i) const { return value_.empty() || graph_.number(value_[i]) == 0; }

} // namespace skein
