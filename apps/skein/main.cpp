// The driver: skein new | run | expect | branch | verify | converge | equilibrium | modes | path | fit | plan |
// check | describe | info | draw | plot | doctor | manual | completion.
#include "commands.hpp"
#include "document.hpp"
#include "manual.hpp"
#include "options.hpp"
#include "solve_commands.hpp"
#include "unknown_word.hpp"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <string_view>

namespace {

using skein::add_json, skein::add_lanes, skein::add_mapping, skein::add_overrides, skein::add_progress,
    skein::add_scene_options, skein::add_threads;

constexpr const char* examples = R"(Examples:
  skein new pile                                  write pile.toml, a scene to begin from; skein new: all kinds
  mpirun -n 4 skein run carpet_8x8.toml           run; the same command again resumes from the last checkpoint
  skein run row_8.toml --set time.duration=72 --out out/short
  mpirun -n 2 --map-by slot:PE=8 --bind-to core skein run farm.toml --threads 8 --walltime 3600
  skein branch out/farm@12800 out/finer --set time.dt=1e-4    continue from a state under other numbers; then skein run out/finer
  skein verify out/farm                           compute the segment between two checkpoints again and compare the bits
  skein converge carpet_8x8.toml --tolerance 1e-3 errors and costs of other numbers of elements and steps
  skein draw out/carpet_8x8 --movie carpet.mp4    a picture, a movie or a page of any run
  skein plot out/net --columns 'joint_*'          columns of the time series of any run
  skein plan carpet_8x8.toml                      what will run: step, memory, predicted cost; -v: passes, limits
  skein describe rods.material                    the keys of a table; skein describe: all of them
Exit codes: 0 done, 2 input, 3 stopped by a limit, 4 numerical, 5 I/O, 6 MPI or internal, 7 verify found other bits, 8 time.relax did not settle, 9 not as expected, 10 unstable, or not known to be stable.
)";

/// Commands of the Python package.
const std::map<std::string, const char*, std::less<>> in_python = {
    {"draw", "pictures, movies and pages of a run's results; draw --help"},
    {"plot", "columns of observables.csv over time, paths of equilibria and modes; plot --help"},
    {"export", "rods of a frame as a file of points: CSV, SWC, NumPy, HDF5; export --help"},
    {"doctor", "checks MPI, HDF5, Python and VTK, and prints what to install"}};

/// Rank among the processes of an MPI launcher, without starting MPI.
bool first_process() {
    for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"})
        if (const char* rank = std::getenv(name)) return std::atoi(rank) == 0;
    return true;
}

const std::map<std::string, skein::RewindMode> rewinds = {
    {"auto", skein::RewindMode::automatic}, {"always", skein::RewindMode::always}, {"never", skein::RewindMode::never}};
const std::map<std::string, skein::Balance> balances = {
    {"auto", skein::Balance::automatic}, {"always", skein::Balance::always}, {"never", skein::Balance::never}};
const std::map<std::string, skein::Protocol> protocols = {{"asynchronous", skein::Protocol::asynchronous},
                                                          {"synchronous", skein::Protocol::synchronous}};

struct CheckArguments {
    skein::SceneArguments scene;
    bool self = false, json = false; ///< `self`: this build instead of a scene
    int threads = 0, lanes = 0;
};

/// Adds the command with its options; so do the functions below.
CLI::App* add_run(CLI::App& app, skein::RunArguments& run) {
    CLI::App& command = *app.add_subcommand("run", "run a scene, or resume it from its last checkpoint");
    add_scene_options(command, run.scene);
    command.add_option("-o,--out", run.options.out, "directory of results; default out/<scene name>");
    add_threads(command, run.threads);
    command
        .add_option("--shuffle", run.shuffle,
                    "seed of a random order in which threads take their work; the same bits, for checks")
        ->option_text("SEED");
    add_lanes(command, run.lanes);
    add_mapping(command, run.mapping);
    command.add_option("--steps", run.options.steps, "stop after this step")->check(CLI::PositiveNumber);
    command.add_option("--until", run.options.until, "stop at this time [s]")->check(CLI::PositiveNumber);
    command.add_option("--walltime", run.options.walltime, "end with a checkpoint within this many seconds")
        ->check(CLI::PositiveNumber);
    command
        .add_option("--protocol", run.options.protocol,
                    "synchronous: all threads and ranks meet after every step; the same bits, for scaling studies")
        ->transform(CLI::CheckedTransformer(protocols))
        ->option_text("{asynchronous,synchronous}=asynchronous");
    command.add_flag_callback(
        "--no-checkpoint", [&run] { run.options.checkpoint = false; }, "write none, not even at the end; for timing");
    command
        .add_option("--rewind", run.options.rewind,
                    "keep a copy of the state in memory, to find out where a failure began; auto: up to 1 GiB per rank")
        ->transform(CLI::CheckedTransformer(rewinds))
        ->option_text("{auto,always,never}=auto");
    command
        .add_option("--balance", run.options.balance,
                    "whether rods that touch may go to other ranks during the run; auto: where the time that "
                    "it saves pays "
                    "for it; always: at every list of candidates, for checks; the same bits")
        ->transform(CLI::CheckedTransformer(balances))
        ->option_text("{auto,always,never}=auto");
    command.add_flag("--overwrite", run.options.overwrite,
                     "start again; earlier results go to a folder previous_1, _2, ... in it");
    add_progress(command, run.options.progress);
    command.add_flag("-q,--quiet", run.options.quiet, "no plan, no progress, no table");
    add_json(command, run.json, "the summary as JSON at the end; all else goes to standard error");
    command.add_flag("-v,--verbose", run.verbose, "print the whole plan: passes, limits, physics, outputs");
    return &command;
}

CLI::App* add_branch(CLI::App& app, skein::BranchArguments& branch) {
    CLI::App& command =
        *app.add_subcommand("branch", "begin a new directory with the state of a checkpoint, under changed keys");
    command.add_option("FROM", branch.from, "directory of a run, for its newest checkpoint, or DIRECTORY@STEP")
        ->required();
    command.add_option("NEW", branch.to, "directory to begin; `skein run NEW` continues there")->required();
    add_json(command, branch.json, "step, time and changes as JSON");
    command
        .add_option("--set", branch.overrides,
                    "change a key, e.g. --set time.dt=1e-4 (may be repeated): times, loads, damping, contact laws, "
                    "material, how "
                    "walls move, outputs")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
    return &command;
}

CLI::App* add_verify(CLI::App& app, skein::VerifyArguments& verify) {
    CLI::App& command =
        *app.add_subcommand("verify", "compute a segment between two checkpoints again, and compare every bit");
    command.add_option("DIRECTORY", verify.directory, "of a run")->required();
    command.add_option("--segment", verify.segment, "which segment, from 0, or random; default: the last")
        ->type_name("NUMBER");
    add_json(command, verify.json, "steps and digests as JSON");
    add_threads(command, verify.layout.threads);
    add_lanes(command, verify.layout.lanes);
    add_mapping(command, verify.layout.mapping);
    return &command;
}

/// What is solved in place of stepping.
void add_solution_options(CLI::App& command, skein::ConvergeArguments& converge) {
    CLI::Option* equilibrium = command.add_flag("--equilibrium", converge.equilibrium,
                                                "solve for the equilibrium in place of stepping, as skein equilibrium");
    CLI::Option* modes =
        command.add_option("--modes", converge.modes, "the same, and compare this many frequencies, as skein modes")
            ->check(CLI::PositiveNumber)
            ->excludes(equilibrium);
    CLI::Option* along = command
                             .add_option("--along", converge.path.key,
                                         "follow a path and compare its limit and branch points, as skein path")
                             ->excludes(equilibrium)
                             ->excludes(modes);
    CLI::Option* to = command.add_option("--to", converge.path.to, "value where the path ends")->needs(along);
    along->needs(to);
    command.add_option("--from", converge.path.from, "value where the path begins; default: the scene's")->needs(along);
    command.add_option("--step", converge.path.step, "its largest step, as of skein path")
        ->check(CLI::PositiveNumber)
        ->needs(along);
    command.add_option("--points", converge.path.points, "its most points")->check(CLI::PositiveNumber)->needs(along);
}

CLI::App* add_converge(CLI::App& app, skein::ConvergeArguments& converge) {
    CLI::App& command = *app.add_subcommand(
        "converge", "report the error of a scene: run or solve n, 2n and 4n elements, and half the step; print orders, "
                    "Richardson values and error bars of every observable");
    add_scene_options(command, converge.scene);
    command.add_option("-o,--out", converge.out, "directory of all runs; default out/<scene name>_converge");
    command
        .add_option("--tolerance", converge.tolerance,
                    "also the cheapest elements and dt for this error of every observable, over its range, e.g. 1e-3")
        ->check(CLI::PositiveNumber);
    command
        .add_option("--observable", converge.observables,
                    "for the tolerance look at this one alone, by its name in the table (may be repeated)")
        ->type_name("NAME")
        ->allow_extra_args(false);
    command.add_flag("--coarser", converge.coarser,
                     "n/2, n and 2n elements: a third of the cost, and a less certain error bar");
    command.add_flag("--dry-run", converge.dry_run, "print the runs with their predicted cost, and make none");
    add_solution_options(command, converge);
    command.add_flag("--overwrite", converge.overwrite,
                     "start again; earlier results of each run go to a folder previous_1, _2, ... in it");
    add_json(command, converge.json,
             "converge.json at the end, or the runs of --dry-run; all else goes to standard error");
    add_threads(command, converge.threads);
    add_lanes(command, converge.lanes);
    add_mapping(command, converge.mapping);
    add_progress(command, converge.progress);
    return &command;
}

CLI::App* add_plan(CLI::App& app, skein::PlanArguments& plan) {
    CLI::App& command = *app.add_subcommand("plan", "print what a run would do");
    add_scene_options(command, plan.scene);
    add_json(command, plan.json, "the plan as JSON");
    command.add_flag("-v,--verbose", plan.verbose, "print the whole plan: passes, limits, physics, outputs");
    command
        .add_option("-o,--out", plan.out,
                    "results that a run would continue: time of the steps that are left after the newest checkpoint")
        ->check(CLI::ExistingDirectory);
    command
        .add_option("--ranks", plan.ranks,
                    "number of ranks to plan for: rods, ghosts, messages, memory and time of each")
        ->check(CLI::PositiveNumber);
    command
        .add_option("--machine", plan.machine, "cost of messages there: a file that bench/scaling/netcal has written")
        ->type_name("FILE");
    command.add_option("-t,--threads", plan.threads, "threads per rank")->check(CLI::PositiveNumber);
    add_lanes(command, plan.lanes);
    add_mapping(command, plan.mapping);
    return &command;
}

CLI::App* add_check(CLI::App& app, CheckArguments& check) {
    CLI::App& command =
        *app.add_subcommand("check", "read and check a scene, run nothing; or check this build (--self)");
    command.add_option("SCENE", check.scene.file, "scene file (TOML), or a directory that a branch began in");
    add_overrides(command, check.scene);
    add_json(command, check.json, "size, step and notes as JSON; with --self: the digest");
    command.add_flag("--self", check.self,
                     "check this build instead: step a known scene, on all ranks, and compare its digest");
    command.add_option("-t,--threads", check.threads, "of the self-check")->check(CLI::PositiveNumber);
    add_lanes(command, check.lanes);
    command.callback([&check] {
        if (check.self == !check.scene.file.empty()) throw CLI::RequiredError("check: SCENE, or --self,");
    });
    return &command;
}

CLI::App* add_expect(CLI::App& app, skein::ExpectArguments& expect) {
    CLI::App& command = *app.add_subcommand(
        "expect", "run a scene, and compare its time series with the values of its [[expect]] tables");
    add_scene_options(command, expect.run.scene);
    command.add_option("-o,--out", expect.run.options.out, "directory of results; default out/<scene name>");
    command.add_flag("--overwrite", expect.run.options.overwrite, "run again where results exist");
    add_threads(command, expect.run.threads);
    add_lanes(command, expect.run.lanes);
    add_mapping(command, expect.run.mapping);
    add_json(command, expect.json, "a list of the values as JSON; messages go to standard error");
    return &command;
}

CLI::App* add_new(CLI::App& app, skein::NewArguments& arguments) {
    CLI::App& command = *app.add_subcommand("new", "write a commented scene to begin from; without KIND: list all");
    command.add_option("KIND", arguments.kind, "of the scene, e.g. cantilever, pile, motor");
    command.add_option("FILE", arguments.file, "to write; default KIND.toml");
    add_json(command, arguments.json, "the kinds, or the name of the file, as JSON");
    return &command;
}

CLI::App* add_describe(CLI::App& app, skein::DescribeArguments& describe) {
    CLI::App& command =
        *app.add_subcommand("describe", "a scene as TOML with all keys and their meanings, or the keys of scenes");
    command.add_option("SCENE_OR_KEY", describe.what,
                       "scene file, directory of a run's results, or a key such as rods.material; default: all keys");
    add_json(command, describe.json, "keys as JSON: paths, units, types, bounds, defaults");
    return &command;
}

CLI::App* add_info(CLI::App& app, skein::InfoArguments& info) {
    CLI::App& command =
        *app.add_subcommand("info", "build and machine; with a scene or a directory of results, how far the run is");
    command.add_option("SCENE", info.scene.file, "scene file (TOML), or the directory of a run's results");
    command.add_option("-o,--out", info.out, "directory of the scene's results; default out/<scene name>");
    add_json(command, info.json, "as JSON");
    add_overrides(command, info.scene);
    return &command;
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("Skein: large assemblies of soft slender rods.");
    app.footer(examples);
    app.set_version_flag("--version", std::string("skein ") + SKEIN_VERSION);
    app.require_subcommand(1);

    skein::RunArguments run;
    skein::BranchArguments branch;
    skein::VerifyArguments verify;
    skein::ConvergeArguments converge;
    skein::PlanArguments plan;
    CheckArguments check;
    skein::DescribeArguments describe;
    skein::InfoArguments info;
    skein::ExpectArguments expect;
    const CLI::App* expect_command = add_expect(app, expect);
    skein::NewArguments scene;
    const CLI::App* new_command = add_new(app, scene);
    const CLI::App* run_command = add_run(app, run);
    const CLI::App* branch_command = add_branch(app, branch);
    const CLI::App* verify_command = add_verify(app, verify);
    const CLI::App* converge_command = add_converge(app, converge);
    const skein::SolveCommands solve_commands(app);
    const CLI::App* plan_command = add_plan(app, plan);
    const CLI::App* check_command = add_check(app, check);
    const CLI::App* describe_command = add_describe(app, describe);
    const CLI::App* info_command = add_info(app, info);
    const CLI::App* manual_command = app.add_subcommand("manual", "print the man page: skein manual | man -l -");
    const CLI::App* completion_command =
        app.add_subcommand("completion", "print a script for bash: source <(skein completion)");
    for (const auto& [name, text] : in_python) app.add_subcommand(name, text);
    if (argc > 1 && in_python.contains(argv[1])) return first_process() ? skein::python_command(argc, argv) : 0;

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        const bool asked = e.get_exit_code() == 0; // --help, --version
        const std::string unknown = asked ? std::string() : skein::unknown_word(app, argc, argv);
        if (!unknown.empty() && first_process()) std::fprintf(stderr, "error: %s\n", unknown.c_str());
        else if (first_process()) app.exit(e);
        return asked ? 0 : static_cast<int>(skein::Exit::input);
    }

    if (run_command->parsed()) return skein::run_command(run, argc, argv);
    if (expect_command->parsed()) return skein::expect_command(expect, argc, argv);
    if (const auto code = solve_commands.run(argc, argv)) return *code;
    if (branch_command->parsed()) return skein::branch_command(branch, argc, argv);
    if (verify_command->parsed()) return skein::verify_command(verify, argc, argv);
    if (converge_command->parsed()) return skein::converge_command(converge, argc, argv);
    if (check_command->parsed() && check.self)
        return skein::self_check_command(check.threads, check.lanes, check.json, argc, argv);
    if (!first_process()) return 0;
    if (manual_command->parsed()) return std::fputs(skein::manual_page(app, SKEIN_VERSION).c_str(), stdout) < 0;
    if (completion_command->parsed()) return std::fputs(skein::completion_script(app).c_str(), stdout) < 0;
    if (new_command->parsed()) return skein::new_command(scene);
    if (plan_command->parsed()) return skein::plan_command(plan, argc, argv);
    if (check_command->parsed()) return skein::check_command(check.scene, check.json);
    if (describe_command->parsed()) return skein::describe_command(describe, argc, argv);
    return info_command->parsed() ? skein::info_command(info, argc, argv) : static_cast<int>(skein::Exit::internal);
}
