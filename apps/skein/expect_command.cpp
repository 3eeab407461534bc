// Runs a scene, then compares its time series with the values that its [[expect]] tables name.
#include "commands.hpp"
#include "io/csv_table.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

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

std::string json_of(const std::vector<Comparison>& all) {
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
    return rows.dump(2) + "\n";
}

/// The exit code: of the comparison.
int compare(const SceneSpec& scene, const std::string& out, bool json) {
    bool met = true;
    const int code = alone([&] {
        const CsvTable series = read_csv(out + "/observables.csv");
        std::vector<Comparison> all;
        for (const ExpectSpec& expected : scene.expected) {
            const double found = found_in(series, expected);
            all.push_back({expected, found, found - expected.value});
            met = met && all.back().met();
        }
        fmt::print("{}", json ? json_of(all) : table_of(all));
    });
    return code != 0 ? code : met ? 0 : static_cast<int>(Exit::unexpected);
}

} // namespace

int expect_command(ExpectArguments arguments, int& argc, char**& argv, bool first_process) {
    RunArguments& run = arguments.run;
    look_into_directory(run.scene, run.options.out);
    SceneSpec scene;
    const int read = alone([&] {
        scene = read_scene(run.scene.file, run.scene.overrides);
        if (scene.expected.empty())
            throw InputError(fmt::format("{}: the scene expects nothing; it has no [[expect]]", run.scene.file));
    });
    if (read != 0) return read;
    if (run.options.out.empty()) run.options.out = default_out(run.scene.file);
    run.options.quiet = true;
    const std::string out = run.options.out;
    if (const int code = run_command(run, argc, argv); code != 0) return code;
    return first_process ? compare(scene, out, arguments.json) : 0;
}

} // namespace skein
