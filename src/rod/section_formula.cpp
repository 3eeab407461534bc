#include "rod/section_formula.hpp"

#include "rod/shape_places.hpp"

#include <array>
#include <cmath>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr Variable places[] = {Variable::s, Variable::length};

/// Values over `radius` at the middles of elements; empty where there are faults.
std::vector<double> factors(const std::string& text, double radius, const Shape& shape, const FormulaScope& names,
                            std::vector<FormulaFault>& faults) {
    Graph graph(names.tables);
    const auto read = read_formula(graph, names, text, 0, "m", faults);
    const auto refuse = [&](const std::string& message) {
        faults.push_back({{0, text.size(), 0}, message});
        return std::vector<double>();
    };
    if (!read) return {};
    if (graph.varies_beyond(read->node, places)) return refuse("it may name 's', 'L', constants, tables and functions alone");
    std::vector<double> profile;
    std::array<double, variables> at{};
    at[static_cast<std::size_t>(Variable::length)] = shape.length;
    for (const double place : middles_of(shape)) {
        const double s = at[static_cast<std::size_t>(Variable::s)] = place * shape.length;
        const double value = graph.values(at)[static_cast<std::size_t>(read->node)];
        if (!std::isfinite(value) || value <= 0)
            return refuse(fmt::format("it is {:g} m at s = {:.6g} m: above 0 is needed", value, s));
        profile.push_back(value / radius);
    }
    return profile;
}

} // namespace

std::vector<SectionFault> read_section(RodSpec& rods, const FormulaScope& names) {
    if (!faults(names).empty()) return {};
    Section& section = rods.section;
    std::vector<SectionFault> found;
    const auto read = [&](const char* key, const std::string& text, double radius, std::vector<double>& profile) {
        if (text.empty() || !(radius > 0)) return;
        std::vector<FormulaFault> of_formula;
        std::vector<double> values = factors(text, radius, rods.shape, names, of_formula);
        for (const FormulaFault& fault : of_formula) found.push_back({key, fault});
        if (of_formula.empty()) profile = std::move(values);
    };
    read("radius_formula", section.radius_formula, section.radius, section.profile);
    read("radius_2_formula", section.radius_2_formula, section.radius_2, section.profile_2);
    return found;
}

} // namespace skein
