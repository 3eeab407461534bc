// The driver's commands; each returns the exit code of the program.
#pragma once

#include "core/error.hpp"
#include "simulation/simulation.hpp"

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
    int threads = 0; ///< 0: the cores this rank may use
    unsigned shuffle = 0;
    int lanes = 0; ///< 0: as many as the registers hold
    Mapping mapping = Mapping::automatic;
};
struct PlanArguments {
    SceneArguments scene;
    bool json = false;
    int ranks = 0, threads = 0, lanes = 0; ///< 0: those of this machine
    Mapping mapping = Mapping::automatic;
};
struct DescribeArguments {
    std::string what;
};

int run_command(const RunArguments& arguments, int& argc, char**& argv);
int plan_command(const PlanArguments& arguments);
/// Steps the known scene on this build, processor and ranks.
int self_check_command(int threads, int lanes, int& argc, char**& argv);
int check_command(const SceneArguments& arguments);
int describe_command(const DescribeArguments& arguments);
int info_command(const std::string& scene);

} // namespace skein
