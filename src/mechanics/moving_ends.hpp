// Ends in prescribed motion: node and wall are at their places at every force evaluation. theory.md (46)
#pragma once

#include "core/rotation.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/tile.hpp"

#include <cmath>
#include <memory>

namespace skein {

/// Angular velocity, lab, rad/s, of a frame Q R(r) where the rotation vector r changes at `rate`.
SKEIN_INLINE Vec3d spin_of(const Vec3d& r, const Vec3d& rate) {
    const double x = dot(r, r), angle = std::sqrt(x);
    const bool small = x < 1e-4; // differences lose digits there; first omitted terms x^3/40320 and x^3/362880
    const double b = small ? 0.5 - x / 24 + x * x / 720 : (1 - std::cos(angle)) / x;
    const double c = small ? 1.0 / 6 - x / 120 + x * x / 5040 : (angle - std::sin(angle)) / (angle * x);
    return rate + b * cross(r, rate) + c * cross(r, cross(r, rate));
}

/// Components of `moved` where `free` is 0, of `own` where it is 1.
template <class P> Vec3<P> held_and_free(const Vec3d& free, const Vec3<P>& moved, const Vec3<P>& own) {
    const auto one = [](double is_free, const P& m, const P& o) { return is_free > 0 ? o : m; };
    return {one(free.x, moved.x, own.x), one(free.y, moved.y, own.y), one(free.z, moved.z, own.z)};
}

/// Frames of a rod's walls at any time. Motions are in the axes of the rod's copy.
inline Quaterniond start_wall_frame(const RodGroup& group, std::int64_t index, double time) {
    return group.frame(index) * rotation(group.to_lab(index, group.spec().start_motion.turn(time).value));
}
inline Quaterniond end_wall_frame(const RodGroup& group, std::int64_t index, double time) {
    return group.end_frame(index) * rotation(group.to_lab(index, group.spec().end_motion.turn(time).value));
}

/// Places of the two ends of a group's rods at the force evaluations of a batch, shared by the passes of a program.
class MovingEnds {
public:
    struct Pose {
        Vec3d displacement{0, 0, 0}, velocity{0, 0, 0};
        Quaterniond frame;      ///< frame of the wall
        Vec3d spin{0, 0, 0};    ///< angular velocity of the wall, body, rad/s
        Quaterniond turn;       ///< R(r)
        Vec3d turning{0, 0, 0}; ///< angular velocity of the wall, rad/s
    };
    explicit MovingEnds(const RodGroup& group) : group_(group) {}

    void prepare(std::span<const Step> steps) {
        const auto pose = [](const EndMotion& motion, const Quaterniond& frame, double time) {
            const auto u = motion.displacement(time);
            const auto r = motion.turn(time);
            const Quaterniond turn = rotation(r.value), turned = frame * turn;
            const Vec3d turning = spin_of(r.value, r.rate);
            return Pose{u.value, u.rate, turned, turned * turning, turn, turning};
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

/// Numbers by which a rod remembers where its ends have been caught: of each end a place, m, and a frame.
inline constexpr std::size_t caught_end_numbers = 3 + 4, caught_ends_numbers = 2 * caught_end_numbers;

/// Walls of the rods of tiles, which the passes of a program share. Rods with directions of their own, and those whose
/// ends have been caught, have walls of their own.
template <int W> class EndWalls {
public:
    using P = Pack<W>;
    enum End { start, end };

    /// `moving`: null where walls stand still.
    explicit EndWalls(std::shared_ptr<const MovingEnds> moving = nullptr) : moving_(std::move(moving)) {}

    void bind(const RodTile<W>& rod) {
        const bool bound = rod.number < own_.size();
        if (bound || !rod.group->walls_differ()) return;
        Own& own = own_.emplace_back();
        for (int l = 0; l < lanes_of<W>; ++l) {
            const Quaterniond axes = rod.group->copy_axes(rod.index[l]), from = inverse(axes);
            set_lane(own.frame[start], l, rod.group->frame(rod.index[l]));
            set_lane(own.frame[end], l, rod.group->end_frame(rod.index[l]));
            set_lane(own.in_axes[start], l, rod.group->frame(rod.index[l]) * from);
            set_lane(own.in_axes[end], l, rod.group->end_frame(rod.index[l]) * from);
            set_lane(own.axes, l, axes);
        }
    }

    /// Notes where the end nodes are at t = 0.
    void bind_home(const RodTile<W>& rod) {
        std::vector<Slot<1>> state(to_index(rod.n) + 1);
        Home& home = home_.emplace_back();
        for (int l = 0; l < lanes_of<W>; ++l) {
            rod.group->start_state(rod.index[l], state);
            set_lane(home.place[start], l, lane(state.front().position, 0));
            set_lane(home.place[end], l, lane(state.back().position, 0));
        }
    }
    /// Place of an end node without its motion, m.
    const Vec3<P>& home(End at, const RodTile<W>& rod) const { return home_[rod.number].place[at]; }

    void append_memory(const RodTile<W>& rod, int l, std::vector<double>& numbers) const {
        if (!rod.group->spec().ends_caught()) return;
        for (const End at : {start, end}) {
            const Vec3d place = lane(home(at, rod), l);
            const Quaterniond frame = lane(own_[rod.number].frame[at], l);
            numbers.insert(numbers.end(), {place.x, place.y, place.z, frame.w, frame.v.x, frame.v.y, frame.v.z});
        }
    }
    std::size_t restore(const RodTile<W>& rod, int l, std::span<const double> in) {
        if (!rod.group->spec().ends_caught()) return 0;
        Own& own = own_[rod.number];
        const Quaterniond from = inverse(rod.group->copy_axes(rod.index[l]));
        std::array<CaughtEnd, 2>& caught = rod.group->caught_ends()[rod.index[l]];
        for (const End at : {start, end}) {
            const auto numbers = in.subspan(at == start ? 0 : caught_end_numbers, caught_end_numbers);
            caught[at] = {{numbers[0], numbers[1], numbers[2]}, {numbers[3], {numbers[4], numbers[5], numbers[6]}}};
            set_lane(home_[rod.number].place[at], l, caught[at].place);
            set_lane(own.frame[at], l, caught[at].frame);
            set_lane(own.in_axes[at], l, caught[at].frame * from);
        }
        return caught_ends_numbers;
    }

    bool moving() const { return moving_ != nullptr; }
    Vec3<P> displacement(End at, const RodTile<W>& rod, const Step& step) const {
        return to_lab(rod, pose(at, step).displacement);
    }
    Vec3<P> velocity(End at, const RodTile<W>& rod, const Step& step) const {
        return to_lab(rod, pose(at, step).velocity);
    }
    /// The same of other motions, as at another time.
    Vec3<P> velocity(End at, const RodTile<W>& rod, const MovingEnds& moving, const Step& step) const {
        return to_lab(rod, (at == start ? moving.start(step) : moving.end(step)).velocity);
    }
    Quaternion<P> frame(End at, const RodTile<W>& rod, const Step& step) const {
        if (moving_) return frame(at, rod, *moving_, step);
        if (own_.empty()) return broadcast<W>(at == start ? rod.group->frame() : rod.group->end_frame());
        return own_[rod.number].frame[at];
    }
    /// The frame where `moving` has the times of steps.
    Quaternion<P> frame(End at, const RodTile<W>& rod, const MovingEnds& moving, const Step& step) const {
        const MovingEnds::Pose& moved = at == start ? moving.start(step) : moving.end(step);
        if (own_.empty()) return broadcast<W>(moved.frame);
        const Own& own = own_[rod.number];
        return own.in_axes[at] * broadcast<W>(moved.turn) * own.axes;
    }
    /// Angular velocity of the wall, body, rad/s.
    Vec3<P> spin(End at, const RodTile<W>& rod, const Step& step) const {
        return spin_of_pose(at, rod, pose(at, step));
    }
    Vec3<P> spin(End at, const RodTile<W>& rod, const MovingEnds& moving, const Step& step) const {
        return spin_of_pose(at, rod, at == start ? moving.start(step) : moving.end(step));
    }

private:
    /// Frames of walls at the start: in the lab, and in the axes of copies.
    struct Own {
        Quaternion<P> frame[2], in_axes[2], axes;
    };
    struct Home {
        Vec3<P> place[2];
    };
    Vec3<P> spin_of_pose(End at, const RodTile<W>& rod, const MovingEnds::Pose& pose) const {
        if (own_.empty()) return broadcast<W>(pose.spin);
        return own_[rod.number].in_axes[at] * broadcast<W>(pose.turn) * broadcast<W>(pose.turning);
    }
    const MovingEnds::Pose& pose(End at, const Step& step) const {
        return at == start ? moving_->start(step) : moving_->end(step);
    }
    Vec3<P> to_lab(const RodTile<W>& rod, const Vec3d& v) const {
        return own_.empty() ? broadcast<W>(v) : transpose_times(own_[rod.number].axes, broadcast<W>(v));
    }

    std::shared_ptr<const MovingEnds> moving_;
    AlignedVector<Own> own_;   ///< by tile number, where rods are turned or caught
    AlignedVector<Home> home_; ///< by tile number, where ends are led
};

/// Pass after the drift: moved nodes take the place and velocity of the motion, frozen elements the wall's frame and
/// spin.
template <int W> class MoveEndsPass final : public TilePass<W> {
public:
    MoveEndsPass(std::shared_ptr<MovingEnds> ends, std::shared_ptr<EndWalls<W>> walls)
        : ends_(std::move(ends)), walls_(std::move(walls)) {}
    void prepare(std::span<const Step> steps) override { ends_->prepare(steps); }

    void bind(const RodTile<W>& rod) override {
        walls_->bind(rod);
        walls_->bind_home(rod);
    }
    void append_memory(const RodTile<W>& rod, int lane, std::vector<double>& numbers) const override {
        walls_->append_memory(rod, lane, numbers);
    }
    std::size_t restore(const RodTile<W>& rod, int lane, std::span<const double> numbers) override {
        return walls_->restore(rod, lane, numbers);
    }

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        const RodSpec& spec = rod.group->spec();
        using Walls = EndWalls<W>;
        const auto move = [&](typename Walls::End end, EndKind kind, int i, Slot<W>& element) {
            Slot<W>& node = rod.slot[i];
            const Vec3<Pack<W>> position = walls_->home(end, rod) + walls_->displacement(end, rod, step),
                                velocity = walls_->velocity(end, rod, step);
            const bool slides = rod.group->slides(i);
            const Vec3d free = slides ? rod.group->free_directions(i) : Vec3d{0, 0, 0};
            node.position = slides ? held_and_free(free, position, node.position) : position;
            node.velocity = slides ? held_and_free(free, velocity, node.velocity) : velocity;
            if (kind == EndKind::clamped_frozen) {
                element.director = walls_->frame(end, rod, step);
                element.spin = walls_->spin(end, rod, step);
            }
        };
        if (spec.start != EndKind::free) move(Walls::start, spec.start, 0, rod.slot[0]);
        if (spec.end != EndKind::free) move(Walls::end, spec.end, rod.n, rod.slot[rod.n - 1]);
    }

private:
    std::shared_ptr<MovingEnds> ends_;
    std::shared_ptr<EndWalls<W>> walls_;
};

} // namespace skein
