#include "equilibrium/path.hpp"

#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace skein {

namespace {

constexpr double slope_step = 1e-4; ///< of the range, by which the number is changed for its slopes
constexpr double most_turn = 1.5;   ///< rad of an element along the tangent
/// Shares of a step within which points are located. The number goes with the square of the way from a limit point.
constexpr double near_limit = 1e-5, near_branch = 1e-9;

/// True where nothing is left along neutral motions, in which corrections have no part.
bool is_balanced(const StaticSolution& solution, const StaticSystem::Balance& balance) {
    constexpr double rounding = 1e-6;
    return std::ranges::all_of(solution.neutral().pieces, [&](const NeutralMotions::Piece& piece) {
        return (piece.motion.transpose() * piece.part_of(balance.residual)).norm() <= rounding * balance.force_size;
    });
}

} // namespace

PathFollower::PathFollower(PathFamily& family, StaticState state, const PathOptions& options)
    : family_(family), options_(options), step_(options.step) {
    now_.state = std::move(state);
    now_.value = options.from;
    StaticSystem& system = family_.at(now_.value);
    now_.friction = system.friction_memory(now_.state);
    weights_ = path_weights(system);
    Direction ahead{Unknown::Zero(system.unknowns()), options.to > options.from ? 1.0 : -1.0};
    if (!find_tangent(now_, ahead)) reason_ = "the stiffness is singular at the start";
}

PathFollower::PathFollower(PathFamily& family, PathMemory memory, const PathOptions& options)
    : family_(family), options_(options), now_(std::move(memory.now)), length_(memory.length), step_(memory.step),
      started_(true), over_(memory.over), beyond_(std::move(memory.beyond)), beyond_length_(memory.beyond_length),
      beyond_place_(memory.beyond_place) {
    // Lengths are over those of the scene where the path began.
    weights_ = path_weights(family_.at(options.from));
}

Unknown path_weights(const StaticSystem& system) {
    Unknown weights(system.unknowns());
    for (int u = 0; u < system.unknowns(); ++u)
        weights[u] = (system.map().place(u).i < 3 ? 1 / (system.length() * system.length()) : 1.0) /
                     std::max(1, system.unknowns() / slot_unknowns);
    return weights;
}

double PathFollower::product(const Direction& a, const Direction& b) const {
    const double range = options_.to - options_.from;
    return a.u.dot(weights_.cwiseProduct(b.u)) + a.p * b.p / (range * range);
}

void PathFollower::normalise(Direction& d) const {
    const double scale = 1 / std::sqrt(product(d, d));
    d.u *= scale;
    d.p *= scale;
}

PathDirection PathFollower::between(const Direction& a, const Direction& b) const {
    Direction mean{a.u + b.u, a.p + b.p};
    normalise(mean);
    return mean;
}

StaticSystem& PathFollower::system_at(double value, const FrictionMemory& friction) {
    StaticSystem& system = family_.at(value);
    system.set_friction_memory(friction);
    return system;
}

Unknown PathFollower::slope(const Place& at) {
    const double h = slope_step * (options_.to - options_.from), value = at.value;
    const auto residual = [&](double p) {
        StaticState own = at.state;
        StaticSystem& system = system_at(p, at.friction);
        system.lead_ends(own);
        return system.balance(own, false).residual;
    };
    try {
        return (8 * (residual(value + h) - residual(value - h)) - (residual(value + 2 * h) - residual(value - 2 * h))) /
               (12 * h);
    } catch (const InputError&) { // of a bound, one side has no values
    }
    const Unknown here = residual(value);
    try {
        return (4 * residual(value + h) - residual(value + 2 * h) - 3 * here) / (2 * h);
    } catch (const InputError&) {
        return (3 * here - 4 * residual(value - h) + residual(value - 2 * h)) / (2 * h);
    }
}

bool PathFollower::find_tangent(Place& place, const Direction& last) {
    const Unknown by_value = slope(place);
    StaticSystem& system = system_at(place.value, place.friction);
    StaticState own = place.state;
    system.refresh(own);
    StaticSystem::Balance balance = system.balance(own, true);
    place.residual = system.relative(balance);
    const StaticSolution tangent(system, own, balance);
    if (!is_balanced(tangent, balance)) return false;
    place.negative = tangent.negative();
    place.tangent = {tangent.solve(by_value), 1};
    if (!place.tangent.u.allFinite()) return false;
    normalise(place.tangent);
    if (product(place.tangent, last) < 0) place.tangent = {-place.tangent.u, -place.tangent.p};
    return true;
}

void PathFollower::keep_friction(Place& place) {
    if (place.friction.empty()) return;
    StaticSystem& system = system_at(place.value, place.friction);
    StaticState own = place.state;
    system.refresh(own);
    system.keep_springs(own);
    place.friction = system.friction_memory(own);
    StaticSystem::Balance balance = system.sticking_balance(own).first;
    place.negative = StaticSolution(system, own, balance).negative();
}

std::optional<PathFollower::Place> PathFollower::step(const Place& from, const Direction& along, double length) {
    Place to;
    to.state = from.state;
    to.friction = from.friction;
    to.value = from.value + length * along.p;
    StaticSystem& ahead = family_.at(to.value);
    // Joints that turn by more than half a turn at once would lose count.
    if (!to.state.joint_memory.empty() && ahead.turn(length * along.u) > most_turn) return {};
    ahead.correct(to.state, length * along.u, 1);
    Direction way{length * along.u, length * along.p};
    const Unknown by_value = slope(to);
    for (to.iterations = 1; to.iterations <= options_.most_iterations; ++to.iterations) {
        StaticSystem& system = system_at(to.value, to.friction);
        StaticState led = to.state;
        system.lead_ends(led);
        led.strain = to.state.strain;
        StaticSystem::Balance balance = system.balance(led, true);
        if (!balance.residual.allFinite()) return {};
        const Unknown residual = balance.residual;
        const StaticSolution tangent(system, led, balance);
        const Unknown own = tangent.solve(residual), other = tangent.solve(by_value);
        const double off = product(along, way) - length;
        const Direction a{own, 0}, b{other, 1};
        const double change = (-off - product(along, a)) / product(along, b);
        const Unknown correction = own + change * other;
        if (!correction.allFinite()) return {};
        if (system.turn(correction) > 1) return {};
        to.state = std::move(led);
        system.correct(to.state, correction, 1);
        to.value += change;
        way.u += correction;
        way.p += change;
        const double size = std::max(system.size(correction), std::abs(change / (options_.to - options_.from)));
        if (size < options_.tolerance) {
            system.refresh(to.state);
            system.keep_joints(to.state);
            if (!find_tangent(to, along)) return {};
            return to;
        }
    }
    return {};
}

std::optional<PathFollower::Place> PathFollower::locate(const Place& from, double length,
                                                        bool (*passed)(const Place& from, const Place& to), double near,
                                                        double& at) {
    double low = 0, high = length;
    std::optional<Place> found;
    // Nothing converges where the stiffness is singular to rounding; a little beside it, something does.
    constexpr std::array shares{0.5, 0.35, 0.65, 0.2, 0.8};
    for (int i = 0; i < 40 && high - low > near * length; ++i) {
        std::optional<Place> there;
        for (const double share : shares) {
            const double middle = low + share * (high - low);
            if (!(there = step(from, from.tangent, middle))) continue;
            (passed(from, *there) ? high : low) = at = middle;
            break;
        }
        if (!there) break;
        found = std::move(there);
    }
    return found;
}

double PathFollower::passed_end(double value) const {
    // It may go back, beyond its start, by as much as it is asked to go on.
    const double back = options_.from - (options_.to - options_.from), low = std::min(back, options_.to),
                 high = std::max(back, options_.to);
    const double near = 0.02 * std::abs(value - now_.value); // no point lies a little before the end
    return value < low + near ? low : value > high - near ? high : std::numeric_limits<double>::quiet_NaN();
}

std::optional<PathFollower::Place> PathFollower::ahead(double& made) {
    std::optional<Place> there;
    while (!(there = step(now_, now_.tangent, step_)) || product(there->tangent, now_.tangent) < 0.5) {
        step_ *= 0.5;
        if (step_ < options_.least_step) {
            reason_ = fmt::format("steps of {:.2g} do not converge beyond {:.6g}", step_, now_.value);
            return {};
        }
    }
    made = step_;
    const double wanted = std::sqrt(static_cast<double>(options_.iterations) / there->iterations);
    step_ = std::clamp(step_ * std::clamp(wanted, 0.5, 1.5), options_.least_step, options_.largest_step);
    return there;
}

std::optional<PathFollower::Place> PathFollower::last(double end, double length) {
    auto there = step(now_, now_.tangent, length);
    if (!there) {
        reason_ = fmt::format("the step to {:.6g} does not converge", end);
        return {};
    }
    StaticSystem& system = system_at(end, there->friction);
    NewtonSolver newton(system, {});
    system.lead_ends(there->state);
    newton.solve(there->state, Unknown::Zero(system.unknowns()));
    system.keep_joints(there->state);
    there->value = end;
    find_tangent(*there, now_.tangent);
    return there;
}

std::optional<PathPoint> PathFollower::next() {
    const auto point = [&](PathPlace place) {
        over_ = place == PathPlace::end;
        keep_friction(now_);
        return PathPoint{now_.value, length_, place, now_.negative, now_.iterations, now_.residual};
    };
    if (over_ || !reason_.empty()) return {};
    if (!started_) {
        started_ = true;
        return point(PathPlace::regular);
    }
    if (beyond_) { // the rest of a step
        now_ = std::move(*beyond_);
        beyond_.reset();
        length_ = beyond_length_;
        return point(beyond_place_);
    }
    negative_before_ = now_.negative;
    double made = 0;
    std::optional<Place> there = ahead(made);
    if (!there) return {};
    PathPlace place = PathPlace::regular;
    if (const double end = passed_end(there->value); !std::isnan(end)) {
        made *= (end - now_.value) / (there->value - now_.value);
        place = PathPlace::end;
        there = last(end, made);
        if (!there) return {};
    }
    const auto turned = [](const Place& a, const Place& b) { return a.tangent.p * b.tangent.p < 0; };
    const auto changed = [](const Place& a, const Place& b) { return a.negative != b.negative; };
    const bool limit = turned(now_, *there);
    if (limit || (now_.friction.empty() && changed(now_, *there))) {
        double at = 0;
        std::optional<Place> critical =
            limit ? locate(now_, made, turned, near_limit, at) : locate(now_, made, changed, near_branch, at);
        if (critical) {
            // At a branch point the stiffness is singular, and its solution has any share of the other path.
            if (!limit) critical->tangent = between(now_.tangent, there->tangent);
            beyond_ = std::move(there);
            beyond_length_ = length_ + made;
            beyond_place_ = place;
            now_ = std::move(*critical);
            length_ += at;
            return point(limit ? PathPlace::limit : PathPlace::branch);
        }
    }
    now_ = std::move(*there);
    length_ += made;
    return point(place);
}

bool PathFollower::switch_branch(double side) {
    // The direction of the smallest eigenvalue, by inverse iteration, less its part along the path.
    StaticSystem& system = family_.at(now_.value);
    StaticState own = now_.state;
    system.refresh(own);
    StaticSystem::Balance balance = system.balance(own, true);
    const StaticSolution tangent(system, own, balance);
    Direction across{Unknown(system.unknowns()), 0};
    for (Eigen::Index i = 0; i < across.u.size(); ++i) across.u[i] = std::cos(1.3 * static_cast<double>(i)); // any
    for (int i = 0; i < 8; ++i) {
        across.u = tangent.solve(across.u.cwiseProduct(weights_));
        normalise(across);
    }
    const double share = product(across, now_.tangent);
    across.u -= share * now_.tangent.u;
    across.p -= share * now_.tangent.p;
    normalise(across);
    across = {side * across.u, side * across.p};
    beyond_.reset();
    over_ = false;
    for (double length = options_.step; length > options_.least_step; length *= 0.5)
        if (auto there = step(now_, across, length)) {
            if (product(there->tangent, across) < 0) there->tangent = {-there->tangent.u, -there->tangent.p};
            now_ = std::move(*there);
            length_ += length;
            step_ = length;
            return true;
        }
    return false;
}

} // namespace skein
