#include "fluid/flow.hpp"

#include <algorithm>
#include <cmath>

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
            const Vec3d v = velocity(first + Vec3d{spacing * static_cast<double>(i), 0, 0});
            row[i] = component == 0 ? v.x : component == 1 ? v.y : v.z;
        }
    }));
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
    const double by_speed = speed > 0 ? courant * h / speed : HUGE_VAL,
                 by_viscosity = viscosity > 0 && constants.scheme != FlowScheme::crank_nicolson
                                    ? stable / margin * h * h / viscosity
                                    : HUGE_VAL;
    return std::min(by_speed, by_viscosity);
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
