// Wall time by phase of a run.
#pragma once

#include "skein/core/index.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <string_view>

namespace skein {

inline double wall_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

enum class Phase {
    setup,
    rods,
    exchange,
    search,
    contacts,
    fluid,
    markers,
    balance,
    observe,
    output,
    checkpoint,
    agree
};
inline constexpr std::string_view phase_names[] = {"setup",   "rods",    "exchange", "search", "contacts",   "fluid",
                                                   "markers", "balance", "observe",  "output", "checkpoint", "agree"};
inline constexpr std::size_t phase_count = std::size(phase_names);

class Timers {
public:
    /// Adds the time until its destruction to a phase.
    class Guard {
    public:
        Guard(double& total) : total_(total), start_(wall_seconds()) {}
        ~Guard() { total_ += wall_seconds() - start_; }
        Guard(const Guard&) = delete;
        Guard& operator=(const Guard&) = delete;

    private:
        double& total_;
        double start_;
    };
    Guard time(Phase phase) { return Guard(nth(seconds_, phase)); }
    void add(Phase phase, double seconds) { nth(seconds_, phase) += seconds; }
    /// Moves time that was counted as one phase to another.
    void move(Phase from, Phase to, double seconds) {
        nth(seconds_, from) -= seconds;
        nth(seconds_, to) += seconds;
    }
    double seconds(Phase phase) const { return nth(seconds_, phase); }

private:
    std::array<double, phase_count> seconds_{};
};

} // namespace skein
