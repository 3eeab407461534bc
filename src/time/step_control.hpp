// Number of equal parts of a step, by the error of positions or because corrections do not converge.
//   error     a third of the difference between steps in p and in p/2 parts: that of p parts, at second order
//   allowed   tolerance times the step's share of the duration
// Errors are compared at some steps alone: at the next after a change, then at every second and at every fourth.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace skein {

class StepControl {
public:
    static constexpr std::int64_t most_parts = std::int64_t{1} << 20;

    /// `allowed`: error of positions in a step, m; 0: parts change only where corrections do not converge.
    explicit StepControl(double allowed) : allowed_(allowed), parts_(allowed > 0 ? 2 : 1) {}

    std::int64_t parts() const { return parts_; }
    /// True where the next step is compared with one of half as many parts.
    bool compares() const { return allowed_ > 0 && wait_ == 0; }
    bool allows(double error) const { return error <= allowed_; }
    /// Twice as many parts; false where that are too many.
    bool refine() {
        parts_ *= 2;
        interval_ = 1;
        return parts_ <= most_parts;
    }
    /// A step is done. `error`: that of the comparison.
    void note_compared(double error) {
        error_ = error;
        constexpr double margin = 6; // half as many parts have four times the error
        if (parts_ > 2 && margin * error < allowed_) {
            parts_ /= 2;
            interval_ = 1;
        } else interval_ = std::min<std::int64_t>(4, 2 * interval_);
        wait_ = interval_ - 1;
    }
    void note() {
        if (wait_ > 0) --wait_;
        else if (allowed_ == 0) parts_ = std::max<std::int64_t>(1, parts_ / 2);
    }
    double error() const { return error_; } ///< of the last comparison, m

    std::vector<double> numbers() const {
        return {static_cast<double>(parts_), static_cast<double>(interval_), static_cast<double>(wait_), error_};
    }
    void set(const std::vector<double>& numbers) {
        parts_ = static_cast<std::int64_t>(numbers.at(0));
        interval_ = static_cast<std::int64_t>(numbers.at(1));
        wait_ = static_cast<std::int64_t>(numbers.at(2));
        error_ = numbers.at(3);
    }

private:
    double allowed_;
    std::int64_t parts_, interval_ = 1, wait_ = 0;
    double error_ = 0;
};

/// Parts of a step by the way of what moves in it: one after the other, each a power of two of the step, as long as the
/// fastest node goes no farther than allowed.
class PaceControl {
public:
    static constexpr std::int64_t most_parts = std::int64_t{1} << 20;

    /// `allowed`: way in a part, m; HUGE_VAL: any.
    explicit PaceControl(double allowed) : allowed_(allowed) {}

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
