// Steps of constant length. The canonical state is staggered: after step N positions and directors stand at t_N - dt/2, rates
// at t_N. A step is drift, forces, kick; only the first drift of a run is half a step (theory.md (20)-(21)).
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace skein {

struct Step {
    std::int64_t index;  ///< 1 for the first step of the run
    double dt;           ///< s
    double drift;        ///< s, length of this step's drift: dt, or dt/2 in the first step
    double time_mid;     ///< s, where forces are evaluated: (index - 1/2) dt
    int slot;            ///< place of this step in its batch: row of the tables that loads prepare
};

/// Deals out batches of steps; knows nothing of rods.
class Clock {
public:
    static constexpr int largest_batch = 64; ///< steps of one tile visit; beyond 16 nothing is gained (performance.md)

    Clock(double dt, std::int64_t steps_done) : dt_(dt), done_(steps_done) { batch_.reserve(largest_batch); }

    double dt() const { return dt_; }
    std::int64_t done() const { return done_; }
    double time() const { return static_cast<double>(done_) * dt_; }

    /// The next steps, at most up to step `until`.
    std::span<const Step> next(std::int64_t until) {
        const auto count = std::min<std::int64_t>(largest_batch, until - done_);
        batch_.clear();
        for (int i = 0; i < count; ++i) {
            const std::int64_t index = done_ + 1 + i;
            batch_.push_back({index, dt_, index == 1 ? 0.5 * dt_ : dt_, (static_cast<double>(index) - 0.5) * dt_, i});
        }
        return batch_;
    }
    void advance(std::span<const Step> batch) { done_ += static_cast<std::int64_t>(batch.size()); }

private:
    double dt_;
    std::int64_t done_;
    std::vector<Step> batch_;
};

} // namespace skein
