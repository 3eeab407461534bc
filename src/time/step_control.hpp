// Number of equal parts of a step, by the error of places or because corrections do not converge. theory.md
// (116)-(118)
//   companion   a second run in half as many parts. Its distance is an estimate of the error so far, with all growth.
//   local       the difference between the step in p and in p/2 parts from the same state
//   gain        the largest distance so far over the sum of local differences: how errors add up in this scene
//   allowed     local difference of a step: its share of what the tolerance leaves, over the gain that is expected
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace skein {

class StepControl {
public:
    static constexpr std::int64_t most_parts = std::int64_t{1} << 20;

    /// `tolerance`: error of places in the whole run, m; 0: parts change only where corrections do not converge.
    /// `steps`: of the run. `enough`: parts that resolve all motion; no more are made for an error, which is reported.
    /// `fewest`: parts by which loads are seen, where there is a tolerance.
    explicit StepControl(double tolerance, std::int64_t steps = 1, std::int64_t enough = most_parts, double fewest = 0);

    bool limited() const { return tolerance_ > 0; }
    std::int64_t parts() const { return parts_; }
    std::int64_t largest() const { return largest_; } ///< parts of a step, since the start of this run
    /// No fewer parts than these.
    void at_least(double parts) {
        while (static_cast<double>(parts_) < parts && parts_ < limit_) parts_ *= 2;
        largest_ = std::max(largest_, parts_);
    }
    bool can_refine() const { return 2 * parts_ <= limit_; }
    /// Cause of the last failed attempt.
    enum class Obstacle { corrections, error, contact, speed };
    Obstacle obstacle() const { return obstacle_; }
    void note_obstacle(Obstacle obstacle) { obstacle_ = obstacle; }
    /// Gives up at fewer parts than `most_parts`.
    void limit(std::int64_t most) { limit_ = most; }

    /// Local difference that the next step may have, m.
    double allowed() const;
    /// False where a step with this change of the distance from the companion is to be compared.
    bool trusts(double change) const;
    bool allows(double local) const { return parts_ >= enough_ || local <= allowed(); }
    /// Twice as many parts; false where that are too many.
    bool refine();
    /// A step is done with the local difference that a comparison has found.
    void note_compared(double local, double distance, double change);
    /// A step is done that was trusted.
    void note_trusted(double distance, double change);
    /// A step without a limit is done.
    void note();

    /// Rate of the longest part in which loads that hold for it are stable, by the last step, 1/s; 0 where none act.
    double touching_rate() const { return touching_rate_; }
    void set_touching_rate(double rate) { touching_rate_ = rate; }

    double distance() const { return distance_; }  ///< of the companion, m
    double most() const { return most_; }          ///< largest so far, m
    double error() const { return compared_ / 3; } ///< of a step by the last comparison, m

    std::vector<double> numbers() const;
    void set(const std::vector<double>& numbers);

private:
    /// Largest distance at the end, m, where no step from now on added to it.
    double expected() const;
    /// Power of time that the largest distance has grown by of late.
    double growth() const;
    void go_on(double local, double distance, bool known);

    double tolerance_, steps_;
    std::int64_t enough_ = most_parts, fewest_ = 1, parts_, largest_ = 1, interval_ = 1, wait_ = 0, limit_ = most_parts;
    double done_ = 0, sum_ = 0, most_ = 0, distance_ = 0, touching_rate_ = 0;
    double compared_ = 0,
           compared_change_ = 0; ///< local difference, and change of the distance, of the last comparison
    Obstacle obstacle_ = Obstacle::corrections;
    double mark_ = 0, mark_most_ = 0, next_mark_most_ = 0; ///< largest distance about half as many steps ago, and when
};

/// Parts of a step by the way of what moves in it: one after the other, each a power of two of the step, as long as the
/// fastest node goes no farther than allowed.
class PaceControl {
public:
    static constexpr std::int64_t most_parts = std::int64_t{1} << 20;

    /// `allowed`: way in a part, m; HUGE_VAL: any.
    explicit PaceControl(double allowed) : allowed_(allowed) {}
    double allowed() const { return allowed_; }

    void begin() { part_ = 0, parts_ = 1; }
    bool ended() const { return part_ == parts_; }
    /// Chooses the next part of a step of `dt` at this speed; false where it would be too short.
    bool choose(double speed, double dt) {
        const auto too_far = [&](std::int64_t parts) { return speed * dt > allowed_ * static_cast<double>(parts); };
        while (parts_ > 1 && part_ % 2 == 0 && !too_far(parts_ / 2)) {
            parts_ /= 2;
            part_ /= 2;
        }
        while (too_far(parts_) && parts_ < most_parts) {
            parts_ *= 2;
            part_ *= 2;
        }
        most_ = std::max(most_, parts_);
        ++made_;
        return !too_far(parts_);
    }
    std::int64_t parts() const { return parts_; }
    std::int64_t part() const { return part_; }
    void next() { ++part_; }

    std::int64_t most() const { return most_; } ///< parts of a step, since the start of this run
    std::int64_t made() const { return made_; } ///< parts of all steps, likewise

private:
    double allowed_;
    std::int64_t part_ = 0, parts_ = 1, most_ = 1, made_ = 0;
};

} // namespace skein
