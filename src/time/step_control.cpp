#include "time/step_control.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace skein {

namespace {
constexpr double aim = 0.9;             ///< share of the tolerance that steps use up
constexpr double least_budget = 0.25;   ///< share of it that is left where it is used up
constexpr double least_gain = 1.0 / 64; ///< of scenes that forget errors
constexpr double wary = 2;              ///< factor on the gain as a run begins
} // namespace

StepControl::StepControl(double tolerance, std::int64_t steps, std::int64_t enough, double fewest)
    : tolerance_(tolerance), steps_(static_cast<double>(std::max<std::int64_t>(1, steps))),
      parts_(tolerance > 0 ? 2 : 1) {
    if (tolerance > 0) at_least(fewest);
    fewest_ = parts_;
    enough_ = std::max(enough, fewest_);
}

double StepControl::expected() const {
    if (done_ <= mark_) return most_;
    return most_ + 4 * (most_ - mark_most_) * (steps_ - done_) / (3 * (done_ - mark_));
}

double StepControl::growth() const {
    if (done_ < 4 || mark_most_ <= 0) return 2;
    return std::log2(most_ / mark_most_) / std::log2(done_ / mark_);
}

double StepControl::allowed() const {
    const double left = std::max(1.0, steps_ - done_);
    const double budget = std::max(least_budget * tolerance_, aim * tolerance_ - expected());
    const double gain = std::clamp(sum_ > 0 ? most_ / sum_ : 1.0, least_gain, 4 * steps_);
    const double ahead = std::max(1.0, left / (done_ + steps_ / wary));
    return budget / (left * gain * std::pow(ahead, std::clamp(growth() - 1, 0.0, 1.0)));
}

bool StepControl::trusts(double change) const {
    return parts_ >= enough_ || change <= allowed() || (wait_ > 0 && change <= 1.5 * compared_change_);
}

bool StepControl::refine() {
    parts_ *= 2;
    largest_ = std::max(largest_, parts_);
    interval_ = 1;
    return parts_ <= limit_;
}

void StepControl::note_compared(double local, double distance, double change) {
    compared_ = local;
    compared_change_ = change;
    go_on(local, distance, true);
}

void StepControl::note_trusted(double distance, double change) {
    const bool small = change <= allowed();
    go_on(small ? change : compared_, distance, small);
}

void StepControl::note() { parts_ = std::max<std::int64_t>(1, parts_ / 2); }

void StepControl::go_on(double local, double distance, bool known) {
    constexpr double margin = 6; // half as many parts have four times the error
    const bool spare = known && parts_ > fewest_ && margin * local < allowed();
    if (spare) parts_ /= 2;
    if (known) {
        interval_ = spare ? 1 : std::min<std::int64_t>(4, 2 * interval_);
        wait_ = interval_ - 1;
    } else if (wait_ > 0) --wait_;
    sum_ += local;
    distance_ = distance;
    most_ = std::max(most_, distance);
    done_ += 1;
    if (done_ == std::exp2(std::floor(std::log2(done_)))) {
        mark_ = std::floor(done_ / 2);
        mark_most_ = next_mark_most_;
        next_mark_most_ = most_;
    }
}

std::vector<double> StepControl::numbers() const {
    return {static_cast<double>(parts_),
            static_cast<double>(interval_),
            static_cast<double>(wait_),
            done_,
            sum_,
            most_,
            distance_,
            compared_,
            compared_change_,
            mark_,
            mark_most_,
            next_mark_most_,
            touching_rate_};
}

void StepControl::set(const std::vector<double>& numbers) {
    parts_ = static_cast<std::int64_t>(numbers.at(0));
    interval_ = static_cast<std::int64_t>(numbers.at(1));
    wait_ = static_cast<std::int64_t>(numbers.at(2));
    double* const to[] = {&done_, &sum_,       &most_,          &distance_, &compared_, &compared_change_,
                          &mark_, &mark_most_, &next_mark_most_};
    for (std::size_t i = 0; i < std::size(to); ++i) *to[i] = numbers.at(3 + i);
    const std::size_t last = 3 + std::size(to);
    touching_rate_ = numbers.size() > last ? numbers[last] : 0; // none in checkpoints of before
}

} // namespace skein
