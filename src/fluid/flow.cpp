#include "fluid/flow.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

FlowFigures& FlowFigures::operator+=(const FlowFigures& plane) {
    kinetic_energy += plane.kinetic_energy, enstrophy += plane.enstrophy, dissipation += plane.dissipation;
    momentum += plane.momentum;
    divergence = std::max(divergence, plane.divergence), speed = std::max(speed, plane.speed);
    return *this;
}

void FlowSolver::set_velocity(const std::function<Vec3d(const Vec3d& place)>& velocity) {
    set_velocity(VelocityRow([&](int component, const Vec3d& first, double spacing, std::span<double> row) {
        for (std::size_t i = 0; i < row.size(); ++i) {
            row[i] = component_of(velocity(first + Vec3d{spacing * static_cast<double>(i), 0, 0}), component);
        }
    }));
}

void FlowSolver::step(double time, double dt) {
    for (int s = 0; s < stage_parts(constants().scheme).count; ++s) begin_stage(s, time, dt), end_stage(s, time, dt);
}

std::int64_t FlowSolver::step_within(double time, double dt, double courant) {
    const double parts = std::ceil(dt / step_limit(courant) * (1 - 1e-12));
    const auto steps = static_cast<std::int64_t>(std::clamp(parts, 1.0, 1e9)); // of what is no number: the first
    const double part = dt / static_cast<double>(steps);
    for (std::int64_t s = 0; s < steps; ++s) step(time + static_cast<double>(s) * part, part);
    return steps;
}

double step_limit(const FlowConstants& constants, double speed, double courant) {
    const double h = constants.grid.h, viscosity = constants.kinematic_viscosity;
    constexpr double stable = 2.5 / 12, margin = 1.5; // of viscosity by itself
    constexpr double steps_of_period = 40;
    const double fastest = std::max(speed, wall_speed(constants)), by_speed = fastest > 0 ? courant * h / fastest : HUGE_VAL,
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
    const double half = std::numbers::pi * constants.frequency; // of the angular frequency
    return std::sin(half * duration) / half * oscillation(constants, from + 0.5 * duration);
}

FlowFigures figures_of(const Communicator& comm, const FlowSolver& flow) {
    constexpr std::size_t numbers = sizeof(FlowFigures) / sizeof(double);
    const std::vector<FlowFigures> mine = flow.figures();
    const std::vector<double> all = comm.all_gather(std::span(reinterpret_cast<const double*>(mine.data()), numbers * mine.size()));
    FlowFigures sum;
    for (std::size_t at = 0; at < all.size(); at += numbers) sum += *reinterpret_cast<const FlowFigures*>(&all[at]);
    return sum;
}

} // namespace skein
