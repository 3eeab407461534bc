#include "formula/scope.hpp"

#include "core/nearest.hpp"
#include "formula/formula.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

namespace skein {

void FormulaTable::fields(FieldVisitor& f) {
    f.visit({.name = "name", .text = "name in formulas, such as gust for gust(t)", .required = true}, name);
    f.visit({.name = "at", .text = "points in ascending order: times, or values of another variable"}, at);
    f.visit({.name = "value", .text = "values at the points, with linear interpolation between them"}, value);
    f.visit({.name = "file",
             .text = "file of comma-separated values, relative to the scene, instead of `at` and `value`: a line of "
                     "names, then a point and its value per line"},
            file);
    f.visit({.name = "at_unit", .text = "unit of the points; empty fits any unit"}, at_unit);
    f.visit({.name = "unit", .text = "unit of the values, such as \"N/m\"; empty fits any unit"}, unit);
    f.visit(
        {.name = "periodic", .text = "true repeats the table after its last point; otherwise it keeps its end values"},
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
    std::size_t i = 1 + static_cast<std::size_t>((x - first) / (last - first) * static_cast<double>(at.size() - 1));
    if (i >= at.size() || !(at[i - 1] <= x && x < at[i])) // points at equal distances need no search
        i = to_index(std::upper_bound(at.begin(), at.end(), x) - at.begin());
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
            found.emplace_back(path, fmt::format("'{}' is reserved in formulas: choose another name", given));
        else if (std::find(taken.begin(), taken.end(), given) != taken.end())
            found.emplace_back(path, fmt::format("two constants or tables are named '{}'", given));
        taken.push_back(given);
    };
    const auto unit = [&](const std::string& path, const std::string& text) {
        if (!text.empty() && !parse_unit(text))
            found.emplace_back(
                path,
                fmt::format("\"{}\" is not a unit: write it with m, kg, s, A, K, N, Pa, J, W, Hz, T, V, C, rad, as in "
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
