#include "commands.hpp"
#include "document.hpp"

#include "io/csv_table.hpp"
#include "io/files.hpp"
#include "scene/scene_file.hpp"
#include "simulation/machine.hpp"
#include "simulation/signals.hpp"
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
    std::string out;
    look_into_directory(arguments.run.scene, out);
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    stop_on_signals();
    return guarded(comm, [&] {
        if (comm.size() > 1) throw InputError("skein fit solves one scene on one rank: start it without mpirun");
        const SceneArguments& scene = arguments.run.scene;
        const SceneText text{scene.file, read_scene_text(scene.file), scene.overrides};
        const Machine machine = machine_of(comm, arguments.run.threads, arguments.run.lanes, arguments.run.mapping);
        const Threads threads(machine.threads);
        FitOptions options{.keys = arguments.keys, .time = arguments.time, .rods = arguments.rods};
        if (options.time < 0) options.time = parse_scene(text.file, text.text, text.overrides).time.duration;
        const FitReport report = fit(comm, threads, machine, text, measurements_of(arguments.data), options);
        std::printf("%s", to_text(report).c_str());
        if (!arguments.run.options.out.empty()) write_file(arguments.run.options.out, to_csv(report));
        if (arguments.run.json) print_document(document_of(report));
        return static_cast<int>(Exit::done);
    });
}

} // namespace skein
