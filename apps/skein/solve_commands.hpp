// Commands that solve a scene in place of stepping it: equilibrium, path, modes, fit.
#pragma once

#include "commands.hpp"

#include <optional>

namespace CLI {
class App;
}

namespace skein {

class SolveCommands {
public:
    explicit SolveCommands(CLI::App& app);
    SolveCommands(const SolveCommands&) = delete;
    SolveCommands& operator=(const SolveCommands&) = delete;
    /// Exit code of the one that the command line names; nothing where it names another.
    std::optional<int> run(int& argc, char**& argv) const;

private:
    void add_equilibrium(CLI::App& app);
    void add_modes(CLI::App& app);
    void add_path(CLI::App& app);
    void add_fit(CLI::App& app);
    void add_gradient(CLI::App& app);

    EquilibriumArguments equilibrium_;
    ModesArguments modes_;
    PathArguments path_;
    FitArguments fit_;
    GradientArguments gradient_;
    const CLI::App *equilibrium_command_ = nullptr, *modes_command_ = nullptr, *path_command_ = nullptr,
                   *fit_command_ = nullptr, *gradient_command_ = nullptr;
};

} // namespace skein
