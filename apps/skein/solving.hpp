// Parts that commands share which solve a scene.
#pragma once

#include "commands.hpp"
#include "simulation/simulation.hpp"
#include "studies/equilibrium_study.hpp"
#include "studies/static_slopes.hpp"

#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace skein {

/// A scene with all that its simulation needs.
struct SolvedScene {
    SceneSpec scene;
    Machine machine;
    std::unique_ptr<Threads> threads;
    std::unique_ptr<Simulation> simulation;
    std::string out; ///< directory of results
};
/// Friction in a solution, for the warning that says so.
enum class Friction {
    with_memory, ///< acts if it has memory; others are zero at rest
    told         ///< before
};
/// Results that a solution finds where it writes.
enum class Directory {
    begins,  ///< there must be none
    goes_on, ///< they are its own
    none     ///< nothing is written
};
/// `suffix`: of the default directory; `change`: of the scene as read. Throws InputError for a scene with parts that
/// cannot be solved. Collective.
SolvedScene solved_scene(const Communicator& comm, const RunArguments& arguments, const std::string& suffix,
                         Friction friction, const std::function<void(SceneSpec&)>& change = {},
                         Directory directory = Directory::begins);

/// A scene that a study solves again and again, with other numbers.
struct StudiedScene {
    const Communicator& comm;
    SceneText text;
    Machine machine;
    double time;                      ///< of loads and ends, s
    std::optional<BegunBodies> begun; ///< of start.from
};
/// Runs a study that the command of this name makes on one rank; `time`: below 0, the scene's end.
int study_on_one_rank(const char* command, const RunArguments& arguments, double time, int& argc, char**& argv,
                      const std::function<void(const StudiedScene&, const Threads&)>& study);

/// Refuses a directory that holds results, unless they are to be overwritten: solutions do not go on where others
/// ended. Collective.
void refuse_results(const Communicator& comm, const RunOptions& options, const std::string& out);

/// A path that was followed and written.
struct FoundPath {
    std::string unit;                     ///< of the number
    std::vector<double> limits, branches; ///< values of the number there
    bool complete = false;
    std::string reason;   ///< why it is not complete
    bool goes_on = false; ///< with --restart
    std::string out;      ///< directory of results
    std::string slopes;   ///< of the number at these points, as text; empty: none were asked for
    nlohmann::ordered_json document;
    Exit code = Exit::done;
    double seconds = 0; ///< without what writing takes
};
/// Throws NumericalError where it has no beginning.
FoundPath follow_path(const Communicator& comm, const PathArguments& arguments);

/// Work of the commands with these names. Collective.
int find_and_write_modes(const Communicator& comm, const ModesArguments& arguments);
int follow_and_write_path(const Communicator& comm, const PathArguments& arguments);

/// Finds the equilibrium and prints how. Throws NumericalError where there is none. Collective.
EquilibriumReport find_and_tell(const SolvedScene& solved, StaticScene& at_rest, double time, bool quiet);

} // namespace skein
