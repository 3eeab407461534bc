// Ends that move as prescribed: node and wall stand where they should at every force evaluation.   theory.md (46)
#pragma once

#include "core/aligned.hpp"
#include "core/rotation.hpp"
#include "rod/tile.hpp"

#include <memory>

namespace skein {

/// Where the two ends of a group's rods are at the force evaluations of a batch; shared by the passes of a program.
class MovingEnds {
public:
    struct Pose {
        Vec3d displacement{0, 0, 0}, velocity{0, 0, 0};
        Mat3d frame; ///< of the wall
    };
    explicit MovingEnds(const RodGroup& group) : group_(group) {}

    void prepare(std::span<const Step> steps) {
        const auto pose = [](const EndMotion& motion, const Mat3d& frame, double time) {
            const auto u = motion.displacement(time);
            return Pose{u.value, u.rate, frame * rotation(motion.turn(time).value)};
        };
        for (const Step& s : steps) {
            start_[s.slot] = pose(group_.spec().start_motion, group_.frame(), s.time);
            end_[s.slot] = pose(group_.spec().end_motion, group_.end_frame(), s.time);
        }
    }
    const Pose& start(const Step& step) const { return start_[step.slot]; }
    const Pose& end(const Step& step) const { return end_[step.slot]; }
    const RodGroup& group() const { return group_; }

private:
    const RodGroup& group_;
    Pose start_[Clock::largest_batch], end_[Clock::largest_batch];
};

/// After the drift: moved nodes go where the motion says, with its velocity; frozen elements take the wall's frame.
template <int W> class MoveEndsPass final : public TilePass<W> {
public:
    static constexpr std::string_view pass_name = "move ends";
    explicit MoveEndsPass(std::shared_ptr<MovingEnds> ends) : ends_(std::move(ends)) {}
    std::string_view name() const override { return pass_name; }
    void prepare(std::span<const Step> steps) override { ends_->prepare(steps); }

    void bind(const RodTile<W>& rod) override {
        std::vector<Slot<1>> state(static_cast<std::size_t>(rod.n) + 1);
        Home& home = home_.emplace_back();
        for (int lane_ = 0; lane_ < W; ++lane_) {
            rod.group->start_state(rod.index[lane_], state);
            set_lane(home.start, lane_, lane(state.front().position, 0));
            set_lane(home.end, lane_, lane(state.back().position, 0));
        }
    }

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        const RodSpec& spec = rod.group->spec();
        const Home& home = home_[rod.number];
        const auto move = [&](const MovingEnds::Pose& pose, const Vec3<Pack<W>>& from, EndKind kind, Slot<W>& node, Slot<W>& element) {
            node.position = from + broadcast<W>(pose.displacement);
            node.velocity = broadcast<W>(pose.velocity);
            if (kind == EndKind::clamped_frozen) element.director = broadcast_frame<W>(pose.frame);
        };
        if (spec.start != EndKind::free) move(ends_->start(step), home.start, spec.start, rod.slot[0], rod.slot[0]);
        if (spec.end != EndKind::free) move(ends_->end(step), home.end, spec.end, rod.slot[rod.n], rod.slot[rod.n - 1]);
    }

private:
    struct Home {
        Vec3<Pack<W>> start, end; ///< node positions at t = 0
    };
    std::shared_ptr<MovingEnds> ends_;
    AlignedVector<Home> home_; ///< by tile number
};

} // namespace skein
