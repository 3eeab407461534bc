// Equilibria along a number of the scene, by arc length: round limit points, onto other branches.  theory.md (102),
// (103)
//   point      (u, p): residual(u, p) = 0
//   tangent    K v = d residual/dp;  (v, 1) over its length, in the direction of the last step
//   length     |du|^2 = sum over nodes and elements of (displacement/L)^2 and turn^2, over their number;  dp over the
//              range asked for
//   step       along the tangent, then Newton's iteration across it
//   stability  signs of the factor of K; one that changes without a turn of p is a branch point
//   friction   with memory: over a step as from load step to load step, its springs go on at each point; no branch
//              points are located then
#pragma once

#include "equilibrium/newton.hpp"

#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

namespace skein {

/// Systems of one scene for values of a number in it.
class PathFamily {
public:
    virtual ~PathFamily() = default;
    /// It stays as it is until the next call.
    virtual StaticSystem& at(double value) = 0;
};

struct PathOptions {
    double from = 0, to = 1; ///< value of the number
    double step = 0.05;      ///< of arc length at first
    double largest_step = 0.2;
    double least_step = 1e-6;
    double tolerance = 1e-10; ///< of a correction
    int iterations = 5;       ///< in which a step should converge
    int most_iterations = 12;
};

enum class PathPlace { regular, limit, branch, end };
inline constexpr std::string_view path_place_names[] = {"regular", "limit", "branch", "end"};

struct PathPoint {
    double value = 0;  ///< of the number
    double length = 0; ///< along the path
    PathPlace place = PathPlace::regular;
    long negative = 0; ///< directions in which the energy falls; -1: not known
    int iterations = 0;
    double residual = 0;
};

/// Unknowns and the number.
struct PathDirection {
    Unknown u;
    double p = 0;
};
/// A place on a path.
struct PathState {
    StaticState state;
    double value = 0;
    PathDirection tangent;
    long negative = 0;
    double residual = 0;
    int iterations = 0;
    FrictionMemory friction{}; ///< of the point before; of this one once the path has it
};
/// All that a path needs to go on with the same bits.
struct PathMemory {
    PathState now;
    double length = 0, step = 0;
    std::optional<PathState> beyond; ///< end of the step in which a point was located
    double beyond_length = 0;
    PathPlace beyond_place = PathPlace::regular;
    bool over = false;
};

/// Weights of the squares of unknowns in lengths along a path.                                          theory.md (102)
Unknown path_weights(const StaticSystem& system);

class PathFollower {
public:
    /// `state`: an equilibrium at options.from.
    PathFollower(PathFamily& family, StaticState state, const PathOptions& options);
    /// Goes on where another ended, whose family and options it has.
    PathFollower(PathFamily& family, PathMemory memory, const PathOptions& options);
    /// Record of the last point.
    PathMemory memory() const { return {now_, length_, step_, beyond_, beyond_length_, beyond_place_, over_}; }

    /// The first point is that of the start. Nothing once the path has left the range, or does not go on.
    std::optional<PathPoint> next();
    const StaticState& state() const { return now_.state; }
    const FrictionMemory& friction() const { return now_.friction; }
    /// Slopes of the loads there by the number, where bodies stay.
    Unknown load_slope() { return slope(now_); }
    /// Directions in which the stability changes in the step that the last point was located in.
    long changed_directions() const { return beyond_ ? std::abs(beyond_->negative - negative_before_) : 0; }
    /// Why it did not go on; empty: it has left the range.
    const std::string& reason() const { return reason_; }
    /// Leaves the path at a branch point, which must be the last, for the other branch: `side` 1 or -1.
    bool switch_branch(double side);

private:
    using Direction = PathDirection;
    using Place = PathState;
    double product(const Direction& a, const Direction& b) const;
    void normalise(Direction& d) const;
    Direction between(const Direction& a, const Direction& b) const;
    /// The system at a value, with these springs of friction.
    StaticSystem& system_at(double value, const FrictionMemory& friction);
    Unknown slope(const Place& at);
    /// Goes from a place along a direction; nothing where Newton's iteration fails.
    std::optional<Place> step(const Place& from, const Direction& along, double length);
    bool find_tangent(Place& place, const Direction& last);
    /// The path has this point: springs of friction go on from it, and all contacts stick there.
    void keep_friction(Place& place);
    /// The end of the range that the value of the next point lies beyond, or nearly at; NaN: it lies within.
    double passed_end(double value) const;
    /// A step forward, of the length `made`; nothing where none converges, with the reason.
    std::optional<Place> ahead(double& made);
    /// The place where the path leaves its range, about `length` ahead.
    std::optional<Place> last(double end, double length);
    /// The place within a step from which on `passed` is true, to `near` of the step; `at`: the way there.
    std::optional<Place> locate(const Place& from, double length, bool (*passed)(const Place& from, const Place& to),
                                double near, double& at);

    PathFamily& family_;
    PathOptions options_;
    Place now_;
    Unknown weights_;
    long negative_before_ = 0; ///< at the beginning of the last step
    double length_ = 0, step_;
    bool started_ = false, over_ = false;
    std::optional<Place> beyond_; ///< end of the step in which a point was located
    double beyond_length_ = 0;
    PathPlace beyond_place_ = PathPlace::regular;
    std::string reason_;
};

} // namespace skein
