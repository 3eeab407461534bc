#include "rod/formulas_along.hpp"

#include "rod/shape_places.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <span>
#include <string_view>

namespace skein {

namespace {

constexpr Variable known[] = {Variable::s, Variable::length};

/// Values [formula][place] at places over the length. Faults are appended, and nothing is returned then. A formula must
/// be readable, depend on s and L alone, and be finite.
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
        node[i] = to_index(read->node);
        if (graph.varies_beyond(read->node, known))
            refuse(i, "it may only use 's', 'L', constants, tables and functions");
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

} // namespace

std::vector<FormulaFault> read_rest_curvature(Shape& shape, const FormulaScope& names) {
    const std::vector<std::string>& texts = shape.rest_curvature_formula;
    if (texts.empty() || !faults(names).empty()) return {};
    if (texts.size() != 3) return {{{}, fmt::format("a vector needs 3 formulas, not {}", texts.size())}};
    std::vector<FormulaFault> found;
    const auto values = values_along(texts, "1/m", shape, vertices_of(shape), names, found);
    if (!found.empty()) return found;
    shape.rest_curvature_profile.clear();
    for (std::size_t k = 0; k < values.front().size(); ++k)
        shape.rest_curvature_profile.push_back({values[0][k], values[1][k], values[2][k]});
    return found;
}

std::vector<SectionFault> read_section(RodSpec& rods, const FormulaScope& names) {
    if (!faults(names).empty()) return {};
    std::vector<SectionFault> found;
    const auto read = [&](const char* key, const std::string& text, double radius, std::vector<double>& profile) {
        if (text.empty() || !(radius > 0)) return;
        std::vector<FormulaFault> of_formula;
        const std::vector<double> places = middles_of(rods.shape);
        auto values = values_along({&text, 1}, "m", rods.shape, places, names, of_formula);
        for (std::size_t k = 0; of_formula.empty() && k < places.size(); ++k)
            if (values[0][k] <= 0)
                of_formula.push_back({{0, text.size(), 0},
                                      fmt::format("it is {:g} m at s = {:.6g} m, but must be above 0", values[0][k],
                                                  places[k] * rods.shape.length)});
        for (const FormulaFault& fault : of_formula) found.push_back({key, fault});
        if (!of_formula.empty()) return;
        for (double& value : values[0]) value /= radius;
        profile = std::move(values[0]);
    };
    Section& section = rods.section;
    read("radius_formula", section.radius_formula, section.radius, section.profile);
    read("radius_2_formula", section.radius_2_formula, section.radius_2, section.profile_2);
    return found;
}

} // namespace skein
