#include "commands.hpp"
#include "document.hpp"
#include "solving.hpp"

#include "io/csv_table.hpp"
#include "io/files.hpp"
#include "studies/fit_study.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>

namespace skein {

namespace {

nlohmann::ordered_json document_of(const FitReport& report) {
    nlohmann::ordered_json numbers = nlohmann::ordered_json::array();
    for (const FittedNumber& one : report.numbers)
        numbers.push_back(
            {{"key", one.key}, {"value", one.value}, {"half_width_95", one.half_width}, {"unit", one.unit}});
    nlohmann::ordered_json misfits = nlohmann::ordered_json::object();
    for (const Misfit& one : report.misfits) misfits[one.of] = one.size;
    return {{"numbers", numbers},
            {"values", report.values},
            {"experiments", report.experiments},
            {"iterations", report.iterations},
            {"misfits", misfits},
            {"seconds", report.seconds}};
}

/// Data are input, as the scene is.
CsvTable measurements_of(const std::string& file) {
    try {
        return read_csv(file);
    } catch (const IoError& error) {
        throw InputError(
            fmt::format("{}; data are a table of comma-separated numbers below a line of names", error.what()));
    }
}

} // namespace

int fit_command(FitArguments arguments, int& argc, char**& argv) {
    return study_on_one_rank(
        "fit", arguments.run, arguments.time, argc, argv, [&](const StudiedScene& scene, const Threads& threads) {
            const FitOptions options{.keys = arguments.keys,
                                     .time = scene.time,
                                     .keep_undetermined = arguments.keep_undetermined,
                                     .rods = arguments.rods,
                                     .begun = scene.begun ? &*scene.begun : nullptr};
            const FitReport report =
                fit(scene.comm, threads, scene.machine, scene.text, measurements_of(arguments.data), options);
            std::printf("%s", to_text(report).c_str());
            if (!arguments.run.options.out.empty()) write_file(arguments.run.options.out, to_csv(report));
            if (arguments.run.json) print_document(document_of(report));
        });
}

} // namespace skein
