#include "solve_commands.hpp"

#include "options.hpp"

#include <CLI/CLI.hpp>

namespace skein {

SolveCommands::SolveCommands(CLI::App& app) { add_equilibrium(app); }

std::optional<int> SolveCommands::run(int& argc, char**& argv) const {
    if (equilibrium_command_->parsed()) return equilibrium_command(equilibrium_, argc, argv);
    return {};
}

namespace {

/// Options of a command that solves a scene.
void add_solve_options(CLI::App& command, RunArguments& run, const char* where) {
    add_scene_options(command, run.scene);
    command.add_option("-o,--out", run.options.out, where);
    command.add_flag("--overwrite", run.options.overwrite,
                     "start again; earlier results go to a folder previous_1, _2, ... in it");
    add_threads(command, run.threads);
    add_lanes(command, run.lanes);
    command.add_flag("-q,--quiet", run.options.quiet, "print nothing");
}

} // namespace

void SolveCommands::add_equilibrium(CLI::App& app) {
    CLI::App& command = *app.add_subcommand(
        "equilibrium", "find where the bodies of a scene are at rest, by Newton's method, and write it as a run's end");
    equilibrium_command_ = &command;
    add_solve_options(command, equilibrium_.run, "directory of results; default out/<scene name>_equilibrium");
    command.add_option("--time", equilibrium_.time, "time of loads and ends [s]; default: the scene's end")
        ->check(CLI::NonNegativeNumber);
    command.add_flag("--stable", equilibrium_.stable, "exit with 10 where the equilibrium is unstable");
    add_json(command, equilibrium_.run.json, "figures of the solution as JSON; all else goes to standard error");
}

} // namespace skein
