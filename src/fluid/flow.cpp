#include "fluid/flow.hpp"

#include "parallel/exact_sum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

int ranks_across(const FlowConstants& constants, int ranks) {
    if (constants.ranks_across > 0) return constants.ranks_across;
    const bool whole_planes = constants.pressure == PressureMethod::multigrid;
    return whole_planes ? 1 : fewest_across(constants.grid, ranks);
}

std::string unshared(const FlowConstants& constants, int ranks) {
    const int across = ranks_across(constants, ranks);
    if (across > 1 && constants.pressure == PressureMethod::multigrid)
        return "multigrid needs whole planes: expected 1 rank across, not " + std::to_string(across);
    return unshared(constants.grid, ranks, across);
}

void FlowSolver::set_velocity(const std::function<Vec3d(const Vec3d& place)>& velocity) {
    set_velocity(VelocityRow([&](int component, const Vec3d& first, double spacing, std::span<double> row) {
        for (std::size_t i = 0; i < row.size(); ++i) {
            row[i] = component_of(velocity(first + Vec3d{spacing * static_cast<double>(i), 0, 0}), component);
        }
    }));
}

void FlowSolver::step(double time, double dt) {
    for (int s = 0; s < stage_parts(constants().scheme).count; ++s) {
        begin_stage(s, time, dt);
        end_stage(s, time, dt);
    }
}

std::int64_t FlowSolver::step_within(double time, double dt, double courant) {
    const double parts = std::ceil(dt / step_limit(courant) * (1 - 1e-12));
    const auto steps = static_cast<std::int64_t>(std::clamp(parts, 1.0, 1e9)); // NaN becomes 1
    const double part = dt / static_cast<double>(steps);
    for (std::int64_t s = 0; s < steps; ++s) step(time + static_cast<double>(s) * part, part);
    return steps;
}

namespace {

bool is_parabolic(const FlowConstants& constants, std::size_t d) {
    return constants.inflow_profile == InflowProfile::parabolic && constants.grid.boundary[d] == FluidBoundary::no_slip;
}

} // namespace

double inflow_share(const FlowConstants& constants, int j, int k) {
    const auto along = [&](std::size_t d, int i) {
        if (!is_parabolic(constants, d)) return 1.0;
        const double n = constants.grid.cells[d], at = (i + 0.5) / n;
        return 6 * at * (1 - at) / (1 + 0.5 / (n * n)); // the mean of all cells is 1
    };
    return along(1, j) * along(2, k);
}

double largest_inflow_share(const FlowConstants& constants) {
    return (is_parabolic(constants, 1) ? 1.5 : 1.0) * (is_parabolic(constants, 2) ? 1.5 : 1.0);
}

namespace {

/// Courant number at which viscosity damps what a scheme makes grow. theory.md (77b)
double damped_courant(const FlowConstants& constants, double speed, double courant) {
    if (!keeps_rates(constants.scheme)) return courant;
    constexpr double least = 0.1; // a wave may grow by e in 4000 cells of way
    const double damped = std::cbrt(8 * constants.kinematic_viscosity / (speed * constants.grid.h));
    return std::min(courant, std::max(damped, least));
}

} // namespace

double step_limit(const FlowConstants& constants, double speed, double courant) {
    const double h = constants.grid.h, viscosity = constants.kinematic_viscosity;
    constexpr double margin = 1.5; // of the limit by viscosity alone
    constexpr double steps_of_period = 40;
    const double stable = (constants.scheme == FlowScheme::adams_bashforth ? 1.0 : 2.5) / 12,
                 fastest = std::max(speed, wall_speed(constants)),
                 by_speed = fastest > 0 ? damped_courant(constants, fastest, courant) * h / fastest : HUGE_VAL,
                 by_viscosity = viscosity > 0 && constants.scheme != FlowScheme::crank_nicolson
                                    ? stable / margin * h * h / viscosity
                                    : HUGE_VAL,
                 by_period = constants.frequency > 0 ? 1 / (steps_of_period * constants.frequency) : HUGE_VAL;
    return std::min({by_speed, by_viscosity, by_period});
}

double wall_speed(const FlowConstants& constants) {
    double most = 0;
    for (const auto& walls : constants.wall_velocity)
        for (const Vec3d& v : walls) most = std::max(most, std::abs(v.x) + std::abs(v.y) + std::abs(v.z));
    return most;
}

double oscillation(const FlowConstants& constants, double time) {
    return constants.frequency > 0 ? std::cos(2 * std::numbers::pi * constants.frequency * time) : 1;
}

double oscillation_integral(const FlowConstants& constants, double from, double duration) {
    if (!(constants.frequency > 0)) return duration;
    const double half = std::numbers::pi * constants.frequency; // half the angular frequency
    return std::sin(half * duration) / half * oscillation(constants, from + 0.5 * duration);
}

FlowFigures figures_of(const Communicator& comm, const FlowSolver& flow) {
    FlowFigures all;
    std::vector<std::vector<double>> terms(6);
    for (const FlowFigures& row : flow.figures()) {
        const double numbers[] = {row.kinetic_energy, row.enstrophy,  row.dissipation,
                                  row.momentum.x,     row.momentum.y, row.momentum.z};
        for (std::size_t i = 0; i < terms.size(); ++i) terms[i].push_back(numbers[i]);
        all.divergence = std::max(all.divergence, row.divergence);
        all.speed = std::max(all.speed, row.speed);
    }
    const std::vector<double> sums = exact_sums(comm, terms);
    all.kinetic_energy = sums[0];
    all.enstrophy = sums[1];
    all.dissipation = sums[2];
    all.momentum = {sums[3], sums[4], sums[5]};
    all.divergence = comm.max(all.divergence);
    all.speed = comm.max(all.speed);
    return all;
}

} // namespace skein
