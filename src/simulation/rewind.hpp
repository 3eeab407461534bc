// Search for the begin of a failure: the run returns to the last copy of its state, repeats the steps and inspects
// each.
#pragma once

#include "simulation/world.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace skein {

/// When a copy of the state is kept in memory.
enum class RewindMode {
    automatic, ///< if it takes less than 1 GiB of a rank
    always,
    never
};

/// Begin of a failure, and its cure.
struct Failure {
    enum class Remedy { unknown, step, untried, none };

    std::string text;
    std::string cause = {};    ///< as far as interactions know it; empty: they do not
    std::string settings = {}; ///< KEY=VALUE that would do, joined by --set
    std::string likely = {};   ///< cause that settings of an interaction cure; empty: none
    std::string frame = {};    ///< file that shows all bodies at that step
    std::int64_t step = -1;    ///< -1: not found
    double dt = 0;             ///< s, the last that was tried; 0: none was
    Remedy remedy = Remedy::unknown;
};

class Rewind {
public:
    Rewind(World& world, RewindMode mode, std::string directory)
        : world_(world), mode_(mode), directory_(std::move(directory)) {}
    ~Rewind();

    /// Copies the state if it is time to. At events.
    void keep_copy();
    /// Drops what has been copied, of bodies that have been changed since.
    void forget();
    /// Failure of some rank, with the step at which it began if there is a copy. `show`: writes outputs of that step.
    /// The run is over after it. Collective.
    Failure find(const std::function<void()>& show);

private:
    struct Found;
    /// Repeats steps from the copy until one fails.
    Found repeat_to_failure();
    void show_failure(Failure& failure, const std::function<void()>& show) const;
    /// Step, pass and contact that did most to the invalid rod, and the limit that follows, s.
    void trace(Failure& failure, const Found& found, double& limit);
    void try_shorter_steps(Failure& failure, const StateCopy& start, double until, double dt);

    World& world_;
    RewindMode mode_;
    std::string directory_;
    std::unique_ptr<StateCopy> copy_, first_; ///< the latter of short runs
    bool was_copied_ = false;
};

/// Message for the user, with cause and cure. `last_checkpoint`: its step; -1: there is none.
std::string text_of(const Failure& failure, const Plan& plan, std::int64_t last_checkpoint,
                    const std::string& directory);

} // namespace skein
