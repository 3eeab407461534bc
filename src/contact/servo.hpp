// Drives a wall forth until the stress on a watched wall is high enough, back until it is low enough, and forth again:
// the lid of a bed of rods that is compressed cycle by cycle.
//   forth -> back   where the stress is above turn_back_above
//   at first       at the speed of approach, until something touches the wall or the place of approach is reached
//   back -> forth   where it is below turn_forth_below and the wall is beyond not_before; after the last cycle it stops
//   there
// It drives while its wall stands: not before the first stage of that, and no longer after the last (docs/stages.md).
#pragma once

#include "contact/wall.hpp"

#include <span>
#include <vector>

namespace skein {

class Servo {
public:
    /// `wall`: as `expanded` gives it.
    explicit Servo(const Wall& wall);

    /// Moves on by h, s, after it has turned if the force that rods exert on the watched wall, N, says so. `touched`:
    /// something touches the driven wall itself.
    void step(double force_on_watched, bool touched, double h);

    WallState wall_state() const { return {offset_ * forth_, (direction_ * speed_) * forth_}; }
    double offset() const { return offset_; }                 ///< along the way forth, m
    double height() const { return start_height_ - offset_; } ///< height of the wall's point against the way forth, m
    int direction() const { return static_cast<int>(direction_); } ///< 1 forth, -1 back, 0 not yet or no longer
    int turns() const { return static_cast<int>(turned_at_.size()); }
    const std::vector<double>& turned_at() const { return turned_at_; } ///< offsets, m: back, forth, back, ...
    bool finished() const { return spec_.cycles > 0 && turns() >= 2 * spec_.cycles; }

    /// Time, offset, direction, speed, mean stress, and where it turned: for checkpoints.
    std::vector<double> state() const;
    void restore(std::span<const double> state);

private:
    ServoSpec spec_;
    bool stands_; ///< its wall, in the present stage
    Vec3d forth_;
    double from_, start_height_;
    double time_ = 0, offset_ = 0, direction_ = 0, speed_ = 0, stress_ = 0;
    std::vector<double> turned_at_;
};

} // namespace skein
