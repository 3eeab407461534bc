// Frames of the walls of clamped ends at both ends of a step.
#pragma once

#include "mechanics/moving_ends.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace skein {

template <int W> class StepWalls {
public:
    using Walls = EndWalls<W>;

    StepWalls(const RodGroup& group, std::shared_ptr<Walls> walls) : walls_(std::move(walls)) {
        if (!walls_->moving()) return;
        before_.emplace(group);
        after_.emplace(group);
    }

    void bind(const RodTile<W>& rod) { walls_->bind(rod); }
    void prepare(std::span<const Step> steps) {
        if (!before_) return;
        std::vector<Step> ends(steps.begin(), steps.end());
        for (Step& step : ends) step.time = step.begin;
        before_->prepare(ends);
        for (Step& step : ends) step.time = step.end();
        after_->prepare(ends);
    }

    Quaternion<Pack<W>> start_frame(typename Walls::End end, const RodTile<W>& rod, const Step& step) const {
        return before_ ? walls_->frame(end, rod, *before_, step) : walls_->frame(end, rod, step);
    }
    Quaternion<Pack<W>> end_frame(typename Walls::End end, const RodTile<W>& rod, const Step& step) const {
        return after_ ? walls_->frame(end, rod, *after_, step) : walls_->frame(end, rod, step);
    }

private:
    std::shared_ptr<Walls> walls_;
    std::optional<MovingEnds> before_, after_;
};

} // namespace skein
