#include "studies/path_slopes.hpp"

#include "equilibrium/newton.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"
#include "studies/scene_number.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skein {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
/// Share of a number by which it is changed once and twice to either side at a branch point.
constexpr double change_at_branch = 4e-3;

/// Slope of f at 0 by differences of fourth order; NaN where those of h and 2h have nothing in common and differ by
/// more than `rounding` of f. On one side of a bound, of second order.
template <class F> double slope_of(const F& f, double h, double rounding) {
    constexpr double alike = 0.05;
    try {
        const double near = (f(h) - f(-h)) / (2 * h), far = (f(2 * h) - f(-2 * h)) / (4 * h);
        const double allowed = std::max(alike * std::max(std::abs(near), std::abs(far)), rounding / h);
        return std::abs(near - far) <= allowed ? (4 * near - far) / 3 : none;
    } catch (const InputError&) { // of a bound, one side has no values
    }
    const double here = f(0);
    try {
        return (4 * f(h) - f(2 * h) - 3 * here) / (2 * h);
    } catch (const InputError&) {
        return (3 * here - 4 * f(-h) + f(-2 * h)) / (2 * h);
    }
}

/// True where the loads of a number act along a critical shape. Branches that cross without them part with them.
bool parts_branches(const Unknown& loads, double number, const CriticalMode& mode, const StaticSystem& system,
                    double force_size) {
    constexpr double rounding = 1e-6;
    const double along = std::abs(mode.shape.dot(loads)), sizes = mode.shape.cwiseAbs().dot(loads.cwiseAbs()),
                 work = force_size * system.length() * system.size(mode.shape);
    return along > rounding * sizes && along * (number != 0 ? std::abs(number) : 1) > 1e-3 * rounding * work;
}

} // namespace

CriticalMode critical_mode(StaticSystem& system, const StaticState& state, bool left, Unknown start) {
    StaticState own = state;
    system.refresh(own);
    StaticSystem::Balance balance = system.balance(own, true);
    Stiffness transposed;
    if (left && !is_symmetric(balance.asymmetry)) {
        transposed = balance.stiffness->transpose();
        balance.stiffness = &transposed;
    }
    const StaticSolution solution(system, own, balance);
    const Unknown weights = path_weights(system);
    CriticalMode mode{0, std::move(start)};
    if (mode.shape.size() == 0) {
        mode.shape.resize(system.unknowns());
        for (Eigen::Index i = 0; i < mode.shape.size(); ++i)
            mode.shape[i] = std::cos(1.3 * static_cast<double>(i)); // any
    }
    mode.shape /= std::sqrt(mode.shape.dot(weights.cwiseProduct(mode.shape)));
    for (int i = 0; i < 60; ++i) {
        const Unknown weighted = weights.cwiseProduct(mode.shape), next = solution.solve(weighted);
        const double before = mode.value, norm = std::sqrt(next.dot(weights.cwiseProduct(next)));
        mode.value = 1 / weighted.dot(next);
        mode.shape = next / norm;
        if (std::abs(mode.value - before) <= 1e-14 * std::abs(mode.value)) break;
    }
    return mode;
}

StateSlopes PathSlopes::at(double value, const StaticState& state, const FrictionMemory& friction) {
    StaticCase& one = family_.case_at(value);
    one.system->set_friction_memory(friction);
    StaticState own = state;
    one.system->refresh(own);
    ObservedCase observed(comm_, threads_, one, asked_.time);
    StateSlopes found = slopes_in(comm_, threads_, machine_, observed, own, asked_);
    for (NumberSlopes& number : found.report.numbers)
        if (!found.regular || number.jumps || number.slips) std::fill(number.slope.begin(), number.slope.end(), none);
    return found;
}

std::vector<double> PathSlopes::of_limit(double value, const StaticState& state, const StateSlopes& there,
                                         const Unknown& by_value) {
    const Unknown left = critical_mode(family_.at(value), state, true).shape;
    std::vector<double> slopes;
    for (std::size_t i = 0; i < there.loads.size(); ++i)
        slopes.push_back(asked_.keys[i] == along_ ? none : -left.dot(there.loads[i]) / left.dot(by_value));
    return slopes;
}

double PathSlopes::eigenvalue_near(StaticCase& at, const StaticState& state, const CriticalMode& mode) const {
    StaticState own = state;
    at.system->lead_ends(own);
    at.system->refresh(own);
    NewtonSolver newton(*at.system, {});
    if (!newton.solve(own, Unknown::Zero(at.system->unknowns())).converged) return none;
    return critical_mode(*at.system, own, false, mode.shape).value;
}

std::vector<double> PathSlopes::of_branch(double value, const StaticState& state, const StateSlopes& there) {
    const CriticalMode mode = critical_mode(family_.at(value), state, false);
    const double step = std::min(value != 0 ? change_at_branch * std::abs(value) : HUGE_VAL, 1e-3 * std::abs(range_));
    const double by_value =
        slope_of([&](double by) { return eigenvalue_near(family_.case_at(value + by), state, mode); }, step, 0);
    StaticCase& one = family_.case_at(value);
    const double force_size = one.system->balance(state, false).force_size;
    std::vector<double> slopes;
    for (std::size_t i = 0; i < asked_.keys.size(); ++i) {
        const std::string& key = asked_.keys[i];
        const double number = there.report.numbers[i].value;
        if (key == along_ || parts_branches(there.loads[i], number, mode, *one.system, force_size)) {
            slopes.push_back(none);
            continue;
        }
        const auto changed = [&](double by) {
            SceneSpec scene = with_number(one.scene, key, number + by);
            check_scene(scene);
            return eigenvalue_near(*static_case(std::move(scene), machine_, asked_.time), state, mode);
        };
        const double rounding = 1e-6 * std::abs(by_value) * step;
        slopes.push_back(-slope_of(changed, change_at_branch * (number != 0 ? std::abs(number) : 1), rounding) /
                         by_value);
    }
    return slopes;
}

} // namespace skein
