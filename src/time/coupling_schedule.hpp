// Steps of rods within steps of a slower partner, such as a fluid: equal intervals, cut into parts of whole units,
// whose stages begin and end between steps of rods.
//
//   interval |----------------------------------------------|      `every` steps of rods
//   parts    |--------------|---------------|---------------|      steps of the partner, as long as it can bear
//   stages   |-------|--|---|-------|--|----|-------|--|----|      shares of a part, in units
#pragma once

#include "time/every.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace skein {

class CouplingSchedule {
public:
    /// `every`: steps of an interval. `stages`: shares of a part's stages; a unit is their sum, in steps of rods.
    CouplingSchedule(std::int64_t every, std::span<const int> stages) : every_{every} {
        for (const int share : stages) until_.push_back(until_.back() + share);
    }

    int stages() const { return static_cast<int>(until_.size()) - 1; }
    std::int64_t unit() const { return until_.back(); }
    /// Steps of rods in the present part.
    std::int64_t part() const { return part_; }

    bool interval_begins(std::int64_t done) const { return every_.due(done); }
    /// The partner chooses the length of a part after step `done`.
    bool part_begins(std::int64_t done) const { return interval_begins(done) || done == first_ + part_; }
    /// Units from step `done` to the end of its interval.
    std::int64_t units_left(std::int64_t done) const { return (every_.next(done) - done) / unit(); }
    void begin_part(std::int64_t done, std::int64_t units) {
        first_ = done;
        part_ = units * unit();
    }

    /// The stage that begins after step `done`, and the one that ends with it.
    std::optional<int> stage_begins(std::int64_t done) const { return stage_at(done, 0); }
    std::optional<int> stage_ends(std::int64_t done) const { return stage_at(done, 1); }
    /// Begin and end of a stage within its part, in shares; each lasts so many steps of rods.
    std::int64_t shares_before(int stage) const { return until_[static_cast<std::size_t>(stage)]; }
    std::int64_t steps_of_share() const { return part_ / unit(); }
    /// First step after `done` at which a stage ends. A part that is not chosen yet ends a step on.
    std::int64_t next(std::int64_t done) const { return part_begins(done) ? done + 1 : end_of_stage(done); }
    /// Step at which the stage ends that goes on after step `done`, in a part that is chosen.
    std::int64_t end_of_stage(std::int64_t done) const {
        for (const std::int64_t shares : until_)
            if (first_ + steps(shares) > done) return first_ + steps(shares);
        return done + 1;
    }

private:
    std::int64_t steps(std::int64_t shares) const { return steps_of_share() * shares; }
    std::optional<int> stage_at(std::int64_t done, int end) const {
        for (int s = 0; s < stages(); ++s)
            if (first_ + steps(shares_before(s + end)) == done) return s;
        return std::nullopt;
    }

    Every every_;
    std::vector<std::int64_t> until_{0}; ///< ends of stages, in shares
    std::int64_t first_ = 0, part_ = 0;  ///< step after which the present part began, and its steps
};

} // namespace skein
