// Runs a scene, then compares its time series with the values that its [[expect]] tables name.
#include "commands.hpp"
#include "document.hpp"
#include "io/csv_table.hpp"
#include "physics/scene_spec.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

struct Comparison {
    const ExpectSpec& expected;
    double found, difference;

    bool met() const { return std::abs(difference) <= expected.allowed(); } // never of NaN
};

std::string table_of(const std::vector<Comparison>& all) {
    std::size_t width = 6;
    for (const Comparison& one : all) width = std::max(width, one.expected.column.size());
    std::string text = fmt::format("{:<{}}  {:<8}{:>14}{:>14}{:>11}{:>11}  reference\n", "column", width, "take",
                                   "expected", "found", "off by", "allowed");
    for (const Comparison& one : all)
        text += fmt::format("{:<{}}  {:<8}{:>14.7g}{:>14.7g}{:>11.2g}{:>11.2g}  {}{}\n", one.expected.column, width,
                            nth(expect_take_names, one.expected.take), one.expected.value, one.found, one.difference,
                            one.expected.allowed(), one.expected.reference, one.met() ? "" : "  NOT MET");
    return text;
}

nlohmann::ordered_json json_of(const std::vector<Comparison>& all) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const Comparison& one : all)
        rows.push_back({{"column", one.expected.column},
                        {"take", nth(expect_take_names, one.expected.take)},
                        {"expected", one.expected.value},
                        {"found", one.found},
                        {"difference", one.difference},
                        {"allowed", one.expected.allowed()},
                        {"reference", one.expected.reference},
                        {"met", one.met()}});
    return rows;
}

/// Prints the comparison and returns its exit code.
int compare(const SceneSpec& scene, const std::string& out, bool json) {
    const CsvTable series = read_csv(out + "/observables.csv");
    std::vector<Comparison> all;
    for (const ExpectSpec& expected : scene.expected) {
        const double found = found_in(series, expected);
        all.push_back({expected, found, found - expected.value});
    }
    if (json) print_document(json_of(all));
    else print_result(table_of(all));
    return std::all_of(all.begin(), all.end(), [](const Comparison& one) { return one.met(); })
               ? 0
               : static_cast<int>(Exit::unexpected);
}

} // namespace

int expect_command(ExpectArguments arguments, int& argc, char**& argv) {
    arguments.run.options.quiet = true;
    const std::string file = arguments.run.scene.file;
    const BesideRun beside{
        [&](const SceneSpec& scene) {
            if (scene.expected.empty())
                throw InputError(fmt::format("{}: the scene expects nothing; it has no [[expect]]", file));
        },
        [&](const SceneSpec& scene, const std::string& out) { return compare(scene, out, arguments.json); }};
    return run_command(std::move(arguments.run), argc, argv, beside);
}

} // namespace skein
