#include "rod/formulas_along.hpp"

#include "skein/core/index.hpp"

#include <array>
#include <cmath>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr Variable known[] = {Variable::s, Variable::length};

} // namespace

std::vector<std::vector<double>> values_along(std::span<const std::string> texts, std::string_view unit,
                                              const Shape& shape, std::span<const double> places,
                                              const FormulaScope& names, std::vector<FormulaFault>& faults) {
    Graph graph(names.tables);
    const std::size_t before = faults.size();
    std::vector<std::size_t> node(texts.size());
    const auto refuse = [&](std::size_t i, const std::string& message) {
        faults.push_back({{0, texts[i].size(), static_cast<int>(i)}, message});
    };
    for (std::size_t i = 0; i < texts.size(); ++i) {
        const auto read = read_formula(graph, names, texts[i], static_cast<int>(i), unit, faults);
        if (!read) continue;
        node[i] = static_cast<std::size_t>(read->node);
        if (graph.varies_beyond(read->node, known))
            refuse(i, "it may name 's', 'L', constants, tables and functions alone");
    }
    if (faults.size() > before) return {};

    std::vector<std::vector<double>> values(texts.size());
    std::array<double, variables> at{};
    nth(at, Variable::length) = shape.length;
    for (const double place : places) {
        const double s = nth(at, Variable::s) = place * shape.length;
        const std::vector<double> of_graph = graph.values(at);
        for (std::size_t i = 0; i < texts.size(); ++i) {
            values[i].push_back(of_graph[node[i]]);
            if (std::isfinite(values[i].back())) continue;
            refuse(i, fmt::format("it is not finite at s = {:.6g} m", s));
            return {};
        }
    }
    return values;
}

} // namespace skein
