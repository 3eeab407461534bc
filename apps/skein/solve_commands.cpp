#include "solve_commands.hpp"

#include "options.hpp"

#include <CLI/CLI.hpp>

namespace skein {

SolveCommands::SolveCommands(CLI::App& app) {
    add_equilibrium(app);
    add_modes(app);
    add_path(app);
    add_fit(app);
    add_gradient(app);
}

std::optional<int> SolveCommands::run(int& argc, char**& argv) const {
    if (equilibrium_command_->parsed()) return equilibrium_command(equilibrium_, argc, argv);
    if (modes_command_->parsed()) return modes_command(modes_, argc, argv);
    if (path_command_->parsed()) return path_command(path_, argc, argv);
    if (fit_command_->parsed()) return fit_command(fit_, argc, argv);
    if (gradient_command_->parsed()) return gradient_command(gradient_, argc, argv);
    return {};
}

namespace {

void add_time(CLI::App& command, double& time) {
    command.add_option("--time", time, "time of loads and ends [s]; default: the scene's end")
        ->check(CLI::NonNegativeNumber);
}

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
    add_time(command, equilibrium_.time);
    command.add_flag("--stable", equilibrium_.stable,
                     "exit with 10 where the equilibrium is unstable, or not known to be stable");
    command.add_flag("--dry-run", equilibrium_.dry_run,
                     "make one correction, print what the factor and a correction take, and write nothing");
    add_json(command, equilibrium_.run.json, "figures of the solution as JSON; all else goes to standard error");
}

void SolveCommands::add_modes(CLI::App& app) {
    CLI::App& command = *app.add_subcommand(
        "modes", "find the equilibrium, and frequencies, decay and shapes of small motions about it");
    modes_command_ = &command;
    add_solve_options(command, modes_.run, "directory of results; default out/<scene name>_modes");
    add_time(command, modes_.time);
    command.add_flag("--undamped", modes_.undamped, "leave out what damps, and gyroscopic couples of spinning rods");
    command.add_option("--count", modes_.count, "modes beside neutral motions")->check(CLI::PositiveNumber);
    command
        .add_option("--movies", modes_.movies, "write the first of these shapes as runs mode_1, mode_2, ... to draw")
        ->check(CLI::NonNegativeNumber);
    command.add_option("--amplitude", modes_.amplitude, "of these, over the length of a rod")
        ->check(CLI::PositiveNumber);
    add_json(command, modes_.run.json, "frequencies as JSON; all else goes to standard error");
}

void SolveCommands::add_path(CLI::App& app) {
    CLI::App& command = *app.add_subcommand(
        "path", "follow equilibria along a number of the scene, round limit points, with stability and branch points");
    path_command_ = &command;
    add_solve_options(command, path_.run, "directory of results; default out/<scene name>_path");
    command.add_option("--along", path_.key, "path of the number, as --set has it, e.g. load.0.end.2")->required();
    command.add_option("--from", path_.from, "value where the path begins; default: the scene's");
    command.add_option("--to", path_.to, "value where it ends")->required();
    add_time(command, path_.time);
    command
        .add_option("--step", path_.step,
                    "largest step: mean displacement over length and mean turn, with the number over its range")
        ->check(CLI::PositiveNumber);
    command.add_option("--points", path_.points, "most points")->check(CLI::PositiveNumber);
    command.add_option("--branch", path_.branch, "leave the path at its first branch point, to the side 1 or -1")
        ->check(CLI::IsMember({-1, 0, 1}));
    command
        .add_option("--by", path_.by,
                    "path of a number (may be repeated) by which slopes are written: of observables at each point, and "
                    "of the path's number at limit and branch points")
        ->type_name("KEY")
        ->allow_extra_args(false);
    command.add_option("--of", path_.of, "an observable for these slopes (may be repeated); default: all")
        ->type_name("OBSERVABLE")
        ->allow_extra_args(false);
    command.add_flag("--restart", path_.restart, "continue a path that was stopped, or whose --points were used up")
        ->excludes(command.get_option("--overwrite"));
    add_json(command, path_.run.json, "the points as JSON; all else goes to standard error");
}

void SolveCommands::add_fit(CLI::App& app) {
    CLI::App& command = *app.add_subcommand(
        "fit", "find numbers of a scene from measured shapes or curves at rest, with intervals of 95 %");
    fit_command_ = &command;
    add_scene_options(command, fit_.run.scene);
    command
        .add_option("DATA", fit_.data,
                    "table (CSV): s, x, y, z of places on a rod; keys of the scene, such as load.0.end.2, that a row "
                    "was measured with; observables by their names in observables.csv")
        ->required()
        ->check(CLI::ExistingFile);
    command.add_option("--number", fit_.keys, "path of a number to find, as --set has it (may be repeated)")
        ->required()
        ->type_name("KEY")
        ->allow_extra_args(false);
    command.add_flag("--keep-undetermined", fit_.keep_undetermined,
                     "leave what the data do not determine as it is in the scene, in place of refusing it");
    command.add_option("--rods", fit_.rods, "group whose first rod the shape is of; default: the first group");
    command.add_option("-o,--out", fit_.run.options.out, "file to write, with comma-separated values; default: none");
    add_time(command, fit_.time);
    add_threads(command, fit_.run.threads);
    add_lanes(command, fit_.run.lanes);
    add_json(command, fit_.run.json, "numbers as JSON; all else goes to standard error");
}

void SolveCommands::add_gradient(CLI::App& app) {
    CLI::App& command = *app.add_subcommand(
        "gradient", "find the equilibrium, and the slopes of all observables there by numbers of the scene");
    gradient_command_ = &command;
    add_scene_options(command, gradient_.run.scene);
    command
        .add_option("--of", gradient_.of,
                    "an observable (may be repeated): each takes one adjoint solution, for any number of numbers")
        ->type_name("OBSERVABLE")
        ->allow_extra_args(false);
    command.add_option("--by", gradient_.keys, "path of a number, as --set has it (may be repeated)")
        ->required()
        ->type_name("KEY")
        ->allow_extra_args(false);
    add_time(command, gradient_.time);
    add_threads(command, gradient_.run.threads);
    add_lanes(command, gradient_.run.lanes);
    add_json(command, gradient_.run.json, "values and slopes as JSON; all else goes to standard error");
}

} // namespace skein
