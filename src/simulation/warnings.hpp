// Warnings of a run, each printed once: states near the limits of the step, the rod law or the discretisation.
#pragma once

#include "simulation/observation.hpp"
#include "simulation/world.hpp"

#include <functional>
#include <set>
#include <string>

namespace skein {

/// Prints "warning: ..." on the stderr of this process.
void print_warning(const std::string& text);

class Warnings {
public:
    Warnings(const World& world, bool quiet) : world_(world), quiet_(quiet) {}

    /// Call before a warning is printed, which ends a line of progress.
    void set_before(std::function<void()> before) { before_ = std::move(before); }
    void end_line() const {
        if (before_) before_();
    }
    /// Prints `text` if `bad`, on root; a second time not. `about`: what it is one of.
    void warn(const std::string& about, bool bad, const std::string& text);

    /// Rank-local question: whether there is something to warn of.
    bool due() const;
    /// Steps near the limit that strains leave, and overlaps beyond those that the step allows for. Collective.
    void warn_of_limits();
    /// Rods without damping whose strains have fed energy. Collective, at the end.
    void warn_of_gain();
    /// Strains and turns in the last sample near the bounds of the rod law or the discretisation.
    void warn_of_strain(const Observation& observation);

private:
    const World& world_;
    bool quiet_;
    std::function<void()> before_;
    std::set<std::string> printed_;
};

} // namespace skein
