// Steps of constant length. The canonical state is staggered: after step N rates are at t_N, positions and directors at
// t_N - lag, dt/2 for Verlet. A step is drift, forces, kick, once or several times (integrator.hpp). Only the first
// drift of a run has no lag to make up for. theory.md (20)-(21)
#pragma once

#include "skein/time/integrator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace skein {

/// One drift and kick: a whole Verlet step, or a stage of a longer one.
struct Step {
    std::int64_t index;                         ///< number of its step, 1 for the first of the run
    double dt;                                  ///< s, of the whole step
    double drift;                               ///< s
    double kick;                                ///< s
    double time;                                ///< s, time of the force evaluation
    int kick_length;                            ///< number among the scheme's kicks
    int slot;                                   ///< place in its batch: row of the tables that loads prepare
    bool completes;                             ///< true for the last stage of its step
    bool last;                                  ///< true for the last one of its batch
    double begin = 0;                           ///< s, of the whole step
    bool first_stage = true, last_stage = true; ///< of the step, or of its part
    double ahead = 0; ///< s, time by which bodies show themselves to each other before they move on

    /// The same for what bodies do to each other: once in a step that looks ahead, over all of it.
    bool meets() const { return ahead == 0 || first_stage; }
    Step meeting() const {
        if (ahead == 0) return *this;
        Step one = *this;
        one.drift = one.kick = dt;
        one.time = begin + ahead;
        return one;
    }

    double end() const { return begin + dt; }
    /// Steps that are done before it.
    std::int64_t before() const { return index - 1; }
};

/// Issues batches of steps.
class Clock {
public:
    static constexpr int largest_batch = 64; ///< stages of one tile visit; beyond 16 nothing is gained (performance.md)

    /// `shift`: time of step 0, s; not 0 where the step was changed during a run, at a time that is no multiple of it.
    Clock(double dt, std::int64_t steps_done, Integrator integrator = Integrator::verlet, double shift = 0)
        : dt_(dt), shift_(shift), scheme_(scheme_of(integrator)), done_(steps_done) {
        batch_.reserve(largest_batch);
    }

    double dt() const { return dt_; }
    std::int64_t done() const { return done_; }
    double shift() const { return shift_; }
    double time() const { return shift_ + static_cast<double>(done_) * dt_; }
    /// Step nearest to a time.
    std::int64_t step_at(double time) const { return std::llround((time - shift_) / dt_); }
    /// Lag of the positions behind time(), s.
    double lag() const { return done_ == 0 ? 0.0 : scheme_.lag * dt_; }

    /// Next whole steps, at most up to step `until` and at most `steps` of them.
    std::span<const Step> next(std::int64_t until, std::int64_t steps = largest_batch) {
        const auto stages = static_cast<std::int64_t>(scheme_.stages.size());
        const std::int64_t last = std::min(until, done_ + std::min(steps, largest_batch / stages));
        batch_.clear();
        for (std::int64_t index = done_ + 1; index <= last; ++index)
            for (const Substep& stage : scheme_.stages) {
                const bool first = &stage == &scheme_.stages.front();
                const double drift = index == 1 && first ? stage.drift - scheme_.lag : stage.drift;
                batch_.push_back({index, dt_, drift * dt_, stage.kick * dt_,
                                  shift_ + (static_cast<double>(index - 1) + stage.time) * dt_, stage.kick_length,
                                  static_cast<int>(batch_.size()), &stage == &scheme_.stages.back(), false,
                                  shift_ + static_cast<double>(index - 1) * dt_, first,
                                  &stage == &scheme_.stages.back(), scheme_.ahead * dt_});
            }
        if (!batch_.empty()) batch_.back().last = true;
        return batch_;
    }
    /// The whole step `index`, as one drift and kick.
    std::span<const Step> next_whole(std::int64_t index) {
        batch_.assign({{index, dt_, dt_, dt_, shift_ + static_cast<double>(index) * dt_, 0, 0, true, true,
                        shift_ + static_cast<double>(index - 1) * dt_}});
        return batch_;
    }
    /// The next `together` whole steps in equal parts: stages of parts from number `first` on, as many as a batch
    /// holds, and no more than `most`.
    std::span<const Step> next_in_parts(std::int64_t parts, std::int64_t first, std::int64_t most = largest_batch,
                                        std::int64_t together = 1) {
        const auto stages = static_cast<std::int64_t>(scheme_.stages.size());
        const std::int64_t end = std::min(parts, first + std::min(most, largest_batch / stages));
        const double part = static_cast<double>(together) * dt_ / static_cast<double>(parts),
                     begin = shift_ + static_cast<double>(done_) * dt_;
        batch_.clear();
        for (std::int64_t p = first; p < end; ++p)
            for (const Substep& stage : scheme_.stages)
                batch_.push_back({done_ + together, part, stage.drift * part, stage.kick * part,
                                  begin + (static_cast<double>(p) + stage.time) * part, stage.kick_length,
                                  static_cast<int>(batch_.size()), p + 1 == parts && &stage == &scheme_.stages.back(),
                                  false, begin + static_cast<double>(p) * part, &stage == &scheme_.stages.front(),
                                  &stage == &scheme_.stages.back(), scheme_.ahead * part});
        if (!batch_.empty()) batch_.back().last = true;
        return batch_;
    }
    void advance(std::span<const Step> batch) {
        if (!batch.empty()) done_ = batch.back().index;
    }

private:
    double dt_, shift_;
    Scheme scheme_;
    std::int64_t done_;
    std::vector<Step> batch_;
};

} // namespace skein
