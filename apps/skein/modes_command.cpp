#include "document.hpp"
#include "solving.hpp"

#include "io/disk.hpp"
#include "io/files.hpp"
#include "studies/modes_study.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace skein {

namespace {

constexpr int movie_frames = 24; ///< of a swing there and back

/// A swing of one mode as the frames of a run.
void write_movie(const Communicator& comm, const ModesArguments& arguments, const StaticScene& at_rest, double time,
                 const PieceMode& mode, const std::string& out) {
    RunArguments run = arguments.run;
    run.options.out = out;
    double dt = at_rest.world().plan.dt;
    SolvedScene movie = solved_scene(comm, run, {}, Friction::told, [dt](SceneSpec& scene) {
        scene.time.dt = dt;
        scene.time.duration = movie_frames * dt;
        scene.output.trajectory = scene.output.series = dt;
    });
    StaticScene moving(movie.simulation->world());
    moving.take_springs(at_rest);
    int frame = 0;
    movie.simulation->go_through([&](World&) {
        const double phase = 2 * std::numbers::pi * ++frame / movie_frames;
        for (std::size_t i = 0; i < moving.pieces().size(); ++i) {
            const StaticPiece& still = at_rest.pieces()[i];
            moving.pieces()[i].state =
                i == mode.piece ? moved_along(still, mode.mode, phase, arguments.amplitude * still.system->length())
                                : still.state;
        }
        moving.show(time, &at_rest);
        return true;
    });
}

nlohmann::ordered_json modes_document(const ModesReport& report, const std::string& out) {
    nlohmann::ordered_json modes = nlohmann::ordered_json::array();
    for (const PieceMode& one : report.modes)
        if (!one.mode.neutral)
            modes.push_back({{"frequency_Hz", one.mode.frequency()},
                             {"eigenvalue", one.mode.eigenvalue},
                             {"decay", one.mode.decay()},
                             {"damping_ratio", one.mode.damping_ratio()},
                             {"residual", one.mode.residual},
                             {"of", one.name}});
    return {{"neutral_motions", report.neutral}, {"method", report.method}, {"modes", modes}, {"results", out}};
}

} // namespace

int find_and_write_modes(const Communicator& comm, const ModesArguments& arguments) {
    const RunOptions& options = arguments.run.options;
    const bool quiet = options.quiet;
    const std::string out = options.out.empty() ? default_out(arguments.run.scene.file) + "_modes" : options.out;
    refuse_results(comm, options, out);
    for (int number = 1; number <= arguments.movies; ++number)
        refuse_results(comm, options, fmt::format("{}/mode_{}", out, number));
    SolvedScene solved = solved_scene(comm, arguments.run, "_modes", Friction::with_memory);
    StaticScene at_rest(solved.simulation->world());
    const double time = arguments.time >= 0 ? arguments.time : solved.scene.time.duration;
    find_and_tell(solved, at_rest, time, quiet);
    const ModesReport report = find_modes(at_rest, arguments.count, arguments.undamped);
    solved.simulation->go_to_end([&](World&) { at_rest.show(time); });
    on_root(comm, [&] { write_file(solved.out + "/modes.csv", to_csv(report)); });
    if (comm.root() && !quiet) std::printf("%s", to_text(report).c_str());
    int number = 0;
    for (const PieceMode& mode : report.modes) {
        if (mode.mode.neutral || ++number > arguments.movies) continue;
        write_movie(comm, arguments, at_rest, time, mode, fmt::format("{}/mode_{}", solved.out, number));
    }
    if (comm.root() && !quiet) std::printf("Written: %s\n", solved.out.c_str());
    if (comm.root() && arguments.run.json) print_document(modes_document(report, solved.out));
    return static_cast<int>(Exit::done);
}

} // namespace skein
