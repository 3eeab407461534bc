#include "simulation/checkpoint_clock.hpp"

#include "core/timer.hpp"

#include <algorithm>

namespace skein {

namespace {

// A guess for the first one: slower than most disks, and what it takes to begin.
constexpr double bytes_per_second = 100e6, begin_s = 0.2;

} // namespace

CheckpointClock::CheckpointClock(double every, double began, double bytes)
    : every_(every), began_(began), last_saved_(wall_seconds()), last_look_(last_saved_),
      saving_s_(begin_s + bytes / bytes_per_second) {}

void CheckpointClock::begin_saving() { saving_began_ = wall_seconds(); }

void CheckpointClock::end_saving() {
    last_saved_ = last_look_ = wall_seconds(); // what it took is no time between two looks
    saving_s_ = last_saved_ - saving_began_;
}

void CheckpointClock::update() {
    const double now = wall_seconds();
    longest_look_s_ = std::max(longest_look_s_, now - last_look_);
    last_look_ = now;
}

bool CheckpointClock::due() const { return every_ > 0 && wall_seconds() - last_saved_ >= every_; }

bool CheckpointClock::late(double limit) const {
    return wall_seconds() - began_ + 2 * saving_s_ + longest_look_s_ > limit;
}

} // namespace skein
