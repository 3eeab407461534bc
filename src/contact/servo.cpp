#include "contact/servo.hpp"

namespace skein {

Servo::Servo(const Wall& wall) : spec_(wall.servo), stands_(wall.stands), from_(wall.from) {
    const double speed = norm(wall.velocity);
    forth_ = speed > 0 ? (1 / speed) * wall.velocity : wall.normal;
    start_height_ = -dot(wall.point, forth_);
}

void Servo::step(double force_on_watched, bool touched, double h) {
    if (!stands_) {
        direction_ = 0;
        time_ += h;
        return;
    }
    if (direction_ == 0 && turns() == 0 && time_ >= from_) {
        direction_ = 1;
        speed_ = spec_.approach > 0 ? spec_.approach : spec_.speed;
    }
    stress_ += (force_on_watched / spec_.area - stress_) * (spec_.average > 0 ? h / (h + spec_.average) : 1.0);
    if (direction_ != 0 && (touched || height() <= spec_.approach_to)) speed_ = spec_.speed;
    const bool turns_back = direction_ > 0 && stress_ > spec_.turn_back_above;
    const bool turns_forth = direction_ < 0 && stress_ < spec_.turn_forth_below && height() > spec_.not_before;
    if (turns_back || turns_forth) {
        turned_at_.push_back(offset_);
        direction_ = finished() ? 0 : -direction_;
    }
    offset_ += direction_ * speed_ * h;
    time_ += h;
}

std::vector<double> Servo::state() const {
    std::vector<double> all{time_, offset_, direction_, speed_, stress_};
    all.insert(all.end(), turned_at_.begin(), turned_at_.end());
    return all;
}

void Servo::restore(std::span<const double> state) {
    time_ = state[0];
    offset_ = state[1];
    direction_ = state[2];
    speed_ = state[3];
    stress_ = state[4];
    turned_at_.assign(state.begin() + 5, state.end());
}

} // namespace skein
