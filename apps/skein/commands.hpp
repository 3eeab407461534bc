// The driver's commands; each returns the exit code of the program.
#pragma once

#include "simulation/simulation.hpp"
#include "skein/core/error.hpp"

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace skein {

struct SceneArguments {
    std::string file;
    std::vector<std::string> overrides;
};
struct RunArguments {
    SceneArguments scene;
    RunOptions options;
    bool verbose = false; ///< all lines of the plan
    bool json = false;    ///< the summary at the end
    int threads = 0;      ///< 0: the cores this rank may use
    unsigned shuffle = 0;
    int lanes = 0; ///< 0: as many as the registers hold
    Mapping mapping = Mapping::automatic;
};
struct PlanArguments {
    SceneArguments scene;
    bool json = false, verbose = false;
    int ranks = 0, threads = 0, lanes = 0; ///< 0: those of this machine
    std::string machine;                   ///< file of netcal; empty: a common network
    std::string out;                       ///< directory whose checkpoint a run would resume; empty: none
    Mapping mapping = Mapping::automatic;
};
struct BranchArguments {
    std::string from, to; ///< DIRECTORY or DIRECTORY@STEP; a new directory
    std::vector<std::string> overrides;
    bool json = false;
};
struct VerifyArguments {
    std::string directory;
    std::string segment; ///< a number, or "random"; empty: the last
    RunArguments layout; ///< threads, lanes and mapping
    bool json = false;
};
struct EquilibriumArguments {
    RunArguments run;
    double time = -1; ///< s, at which loads are taken; below 0: the scene's end
    bool stable = false;
    bool dry_run = false; ///< a plan of the solution, and no more
};
struct ModesArguments {
    RunArguments run;
    double time = -1; ///< s, as above
    int count = 10;
    bool undamped = false;  ///< what damps or spins is left out
    int movies = 0;         ///< modes that are written as moving shapes
    double amplitude = 0.1; ///< of these, over the length of a rod
};
struct PathArguments {
    RunArguments run;
    double time = -1;
    std::string key;                                                ///< path of the number along which it goes
    double from = std::numeric_limits<double>::quiet_NaN(), to = 0; ///< NaN: the scene's
    double step = 0.05;                                             ///< of arc length at first and at most
    int points = 200;                                               ///< at most
    int branch = 0;              ///< side to which the first branch point is left: 1 or -1; 0: none
    std::vector<std::string> by; ///< paths of numbers for slopes; none: no slopes
    std::vector<std::string> of; ///< observables for these; none: all
    bool restart = false;
};
struct ConvergeArguments {
    SceneArguments scene;
    std::string out; ///< empty: out/<scene name>_converge
    bool coarser = false, dry_run = false, json = false, overwrite = false;
    double tolerance = 0;                 ///< of each observable's range; 0: none asked for
    std::vector<std::string> observables; ///< for the tolerance; empty: those that count
    int threads = 0, lanes = 0;           ///< 0: those of this machine
    Mapping mapping = Mapping::automatic;
    ProgressStyle progress = ProgressStyle::automatic;
    bool equilibrium = false; ///< solved in place of stepped, as by the command of this name; so are the next two
    int modes = 0;            ///< how many; 0: none
    PathArguments path;       ///< empty key: none
};
struct FitArguments {
    RunArguments run;
    double time = -1;
    std::string data;              ///< table of measurements
    std::vector<std::string> keys; ///< paths of the numbers to find
    std::string rods;              ///< group of a shape; empty: the first
    bool keep_undetermined = false;
};
struct GradientArguments {
    RunArguments run;
    double time = -1;
    std::vector<std::string> keys; ///< paths of the numbers
    std::vector<std::string> of;   ///< observables; none: all
};
struct ExpectArguments {
    RunArguments run;
    bool json = false;
};
struct NewArguments {
    std::string kind; ///< of apps/recipes; empty: list all
    std::string file; ///< empty: <kind>.toml
    bool json = false;
};
struct DescribeArguments {
    std::string what; ///< scene, results, key or table; empty: all keys
    bool json = false;
};

struct InfoArguments {
    SceneArguments scene; ///< or a directory of results; empty: the build alone
    std::string out;
    bool json = false;
};

/// Work done by every rank alike; what it throws on any rank ends all of them with that error's code, told once by
/// root.
int guarded(const Communicator& comm, const std::function<int()>& work);
/// Read by root alone: a thousand ranks that open one file bring a shared disk to its knees. Throws InputError on all
/// ranks.
std::string text_for_all(const Communicator& comm, const std::string& file);
/// Work of one process without ranks; returns the exit code of what it throws, told once.
int alone(const std::function<void()>& work);
/// Directory of a scene's results where none is named.
std::string default_out(const std::string& scene);
/// Where a scene is a directory, its scene.toml, with that directory for results unless `out` names another.
void look_into_directory(SceneArguments& scene, std::string& out);

/// Scene as read, with its rods.
struct Prepared {
    SceneSpec scene;
    std::vector<RodGroup> groups;
};
/// Reads the scene and packs its rods, which may take long. A signal that reaches some ranks alone stops all of them.
Prepared prepare(const Communicator& comm, const SceneArguments& arguments, const Threads* threads);

/// Work beside a run: before it, on all ranks, and after it, on root alone, which returns the exit code.
struct BesideRun {
    std::function<void(const SceneSpec& scene)> before;
    std::function<int(const SceneSpec& scene, const std::string& out)> after;
};
int run_command(RunArguments arguments, int& argc, char**& argv, const BesideRun& beside = {});
int branch_command(const BranchArguments& arguments, int& argc, char**& argv);
int verify_command(const VerifyArguments& arguments, int& argc, char**& argv);
int converge_command(ConvergeArguments arguments, int& argc, char**& argv);
int plan_command(PlanArguments arguments, int& argc, char**& argv);
/// Finds an equilibrium of a scene; the modes about it; equilibria along a number of the scene.
int equilibrium_command(EquilibriumArguments arguments, int& argc, char**& argv);
int modes_command(ModesArguments arguments, int& argc, char**& argv);
int path_command(PathArguments arguments, int& argc, char**& argv);
/// Prints the slopes of observables at rest by numbers of the scene.
int gradient_command(GradientArguments arguments, int& argc, char**& argv);
/// Finds numbers of a scene from measurements.
int fit_command(FitArguments arguments, int& argc, char**& argv);
/// Steps the known scene on this build, processor and ranks.
int self_check_command(int threads, int lanes, bool json, int& argc, char**& argv);
int check_command(SceneArguments arguments, bool json);
/// Runs a scene, then compares its time series with its [[expect]] tables.
int expect_command(ExpectArguments arguments, int& argc, char**& argv);
/// Writes a scene to begin from.
int new_command(const NewArguments& arguments);
int describe_command(const DescribeArguments& arguments, int& argc, char**& argv);
int info_command(InfoArguments arguments, int& argc, char**& argv);
/// Becomes Skein's Python package (python/), with all words behind the program's name; returns where that cannot be
/// started.
int python_command(int argc, char** argv);

} // namespace skein
