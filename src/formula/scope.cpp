#include "formula/scope.hpp"

#include "core/nearest.hpp"
#include "formula/formula.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

namespace skein {

void FormulaTable::fields(FieldVisitor& f) {
    f.visit({.name = "name", .unit = "", .text = "by which formulas call it, as in gust(t)", .required = true}, name);
    f.visit({.name = "at", .unit = "", .text = "points, rising: times, or whatever it is a function of"}, at);
    f.visit({.name = "value", .unit = "", .text = "its values there, one each; straight lines lie between them"},
            value);
    f.visit({.name = "file",
             .unit = "",
             .text = "instead of both: comma-separated values beside the scene, a line of names, then a point and its "
                     "value a line"},
            file);
    f.visit({.name = "at_unit", .unit = "", .text = "unit of the points; empty: fits any"}, at_unit);
    f.visit({.name = "unit", .unit = "", .text = "unit of the values, as \"N/m\"; empty: fits any"}, unit);
    f.visit({.name = "periodic",
             .unit = "",
             .text = "begins again behind its last point; else it keeps the values of its ends"},
            periodic);
}

std::pair<double, double> FormulaTable::line(double x) const {
    const double first = at.front(), last = at.back();
    if (periodic) {
        const double period = last - first;
        x -= period * std::floor((x - first) / period);
        x = std::clamp(x, first, last);
    }
    if (!(x > first)) return {std::isnan(x) ? x : value.front(), 0.0};
    if (x >= last) return {value.back(), 0.0};
    const auto i = static_cast<std::size_t>(std::upper_bound(at.begin(), at.end(), x) - at.begin());
    const double slope = (value[i] - value[i - 1]) / (at[i] - at[i - 1]);
    return {value[i - 1] + slope * (x - at[i - 1]), slope};
}

std::vector<std::pair<std::string, std::string>> faults(const FormulaScope& scope) {
    std::vector<std::pair<std::string, std::string>> found;
    std::vector<std::string> taken;
    const auto name = [&](const std::string& path, const std::string& given) {
        const auto letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; };
        const bool good = !given.empty() && letter(given[0]) && std::all_of(given.begin(), given.end(), [&](char c) {
            return letter(c) || std::isdigit(static_cast<unsigned char>(c));
        });
        const auto known = known_names({});
        if (!good)
            found.emplace_back(path,
                               fmt::format("'{}' cannot be named in a formula: use letters, digits and _", given));
        else if (std::find(known.begin(), known.end(), given) != known.end())
            found.emplace_back(path, fmt::format("'{}' has a meaning in formulas already: choose another name", given));
        else if (std::find(taken.begin(), taken.end(), given) != taken.end())
            found.emplace_back(path, fmt::format("two constants or tables are named '{}'", given));
        taken.push_back(given);
    };
    const auto unit = [&](const std::string& path, const std::string& text) {
        if (!text.empty() && !parse_unit(text))
            found.emplace_back(
                path,
                fmt::format("\"{}\" is no unit: write it with m, kg, s, A, K, N, Pa, J, W, Hz, T, V, C, rad, as in "
                            "\"kg m/s^2\", without prefixes",
                            text));
    };
    for (const FormulaConstant& c : scope.constants) {
        name("constants." + c.name, c.name);
        unit("constants." + c.name + ".unit", c.unit);
    }
    for (std::size_t i = 0; i < scope.tables.size(); ++i) {
        const FormulaTable& t = scope.tables[i];
        const std::string path = fmt::format("table.{}", i);
        name(path + ".name", t.name);
        unit(path + ".unit", t.unit);
        unit(path + ".at_unit", t.at_unit);
        if (t.at.size() < 2)
            found.emplace_back(path + ".at", "a table needs two points at least, in 'at' or in a 'file'");
        if (t.value.size() != t.at.size())
            found.emplace_back(path + ".value", fmt::format("'value' has {} numbers and 'at' {}: they belong together",
                                                            t.value.size(), t.at.size()));
        for (std::size_t k = 1; k < t.at.size(); ++k)
            if (!(t.at[k] > t.at[k - 1])) {
                found.emplace_back(path + ".at",
                                   fmt::format("points must rise, but {:g} follows {:g}", t.at[k], t.at[k - 1]));
                break;
            }
    }
    return found;
}

} // namespace skein
