#include "rod/rest_curvature.hpp"

#include "rod/shape_places.hpp"

#include <array>
#include <cmath>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr Variable places[] = {Variable::s, Variable::length};

} // namespace

std::vector<FormulaFault> read_rest_curvature(Shape& shape, const FormulaScope& names) {
    const std::vector<std::string>& texts = shape.rest_curvature_formula;
    if (texts.empty() || !faults(names).empty()) return {};
    if (texts.size() != 3) return {{{}, fmt::format("a vector is 3 formulas, not {}", texts.size())}};
    std::vector<FormulaFault> found;
    Graph graph(names.tables);
    std::array<std::size_t, 3> node{};
    const auto refuse = [&](std::size_t i, const std::string& message) {
        found.push_back({{0, texts[i].size(), static_cast<int>(i)}, message});
    };
    for (std::size_t i = 0; i < texts.size(); ++i) {
        const auto read = read_formula(graph, names, texts[i], static_cast<int>(i), "1/m", found);
        if (!read) continue;
        node[i] = static_cast<std::size_t>(read->node);
        if (graph.varies_beyond(read->node, places)) refuse(i, "it may name 's', 'L', constants, tables and functions alone");
    }
    if (!found.empty()) return found;

    std::vector<Vec3d> profile;
    std::array<double, variables> at{};
    at[static_cast<std::size_t>(Variable::length)] = shape.length;
    for (const double place : vertices_of(shape)) {
        const double s = at[static_cast<std::size_t>(Variable::s)] = place * shape.length;
        const std::vector<double> values = graph.values(at);
        profile.push_back({values[node[0]], values[node[1]], values[node[2]]});
        for (std::size_t i = 0; i < texts.size(); ++i)
            if (!std::isfinite(values[node[i]])) {
                refuse(i, fmt::format("it is not finite at s = {:.6g} m", s));
                return found;
            }
    }
    shape.rest_curvature_profile = std::move(profile);
    return found;
}

} // namespace skein
