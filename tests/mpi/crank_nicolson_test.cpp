// Implicit viscosity: what decays as it should, and of what order, at steps far beyond what explicit viscosity allows.
#include "fluid/make_flow.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <vector>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;
using Velocity = std::function<Vec3d(const Vec3d& place)>;

double component(const Vec3d& v, int c) { return c == 0 ? v.x : c == 1 ? v.y : v.z; }

std::unique_ptr<FlowSolver> flow_of(const FlowConstants& constants, const Velocity& velocity) {
    static const Threads threads(1);
    FlowConstants implicit = constants;
    implicit.scheme = FlowScheme::crank_nicolson;
    auto flow = make_flow(Communicator::alone(), threads, implicit);
    flow->set_velocity(velocity);
    return flow;
}

void advance(FlowSolver& flow, double duration, int steps) {
    for (int s = 0; s < steps; ++s) flow.step(duration * s / steps, duration / steps);
}

/// body(value, place) of a component at its faces; of the pressure (3) at centres.
template <class Body> void for_places(const FlowSolver& flow, int c, Body&& body) {
    const FieldLayout layout = flow.layout();
    const FluidGrid& grid = flow.constants().grid;
    const auto field = c < 3 ? flow.velocity(c) : flow.pressure();
    for (int k = 0; k < layout.nz; ++k)
        for (int j = 0; j < layout.ny; ++j)
            for (int i = 0; i < layout.nx; ++i) {
                const Vec3d at{i + (c == 0 ? 1 : 0.5), j + (c == 1 ? 1 : 0.5), k + (c == 2 ? 1 : 0.5)};
                body(nth(field, layout.at(i, j, k)), grid.lower + grid.h * at);
            }
}

double largest_error(const FlowSolver& flow, const Velocity& exact) {
    double most = 0;
    for (int c = 0; c < 3; ++c)
        for_places(flow, c,
                   [&](double u, const Vec3d& at) { most = std::max(most, std::abs(u - component(exact(at), c))); });
    return most;
}

double largest_but_for_mean(const std::vector<double>& all) {
    const double mean = std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
    double most = 0;
    for (const double x : all) most = std::max(most, std::abs(x - mean));
    return most;
}

std::vector<double> values_of(const FlowSolver& flow, int c) {
    std::vector<double> all;
    for_places(flow, c, [&](double u, const Vec3d&) { all.push_back(u); });
    return all;
}

/// But for the mean.
double largest_difference(std::vector<double> a, const std::vector<double>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
    return largest_but_for_mean(a);
}

double order(double coarse, double fine) { return std::log2(coarse / fine); }

/// Not on several ranks, each of which would do the same.
class CrankNicolson : public testing::Test {
protected:
    void SetUp() override {
        if (Communicator::world().size() > 1) GTEST_SKIP() << "the bits are those of one rank";
    }
};

/// Axes of a plane.
struct Plane {
    int first, second;
};
constexpr Plane planes[] = {{0, 1}, {1, 2}, {2, 0}};

Vec3d along(int c, double value) { return {c == 0 ? value : 0, c == 1 ? value : 0, c == 2 ? value : 0}; }

/// Vortices of Taylor and Green in a plane, which let nothing through walls at multiples of 1 and do not rub on them.
Velocity vortices(const Plane& plane, double decay) {
    return [=](const Vec3d& at) {
        const double x = pi * component(at, plane.first), y = pi * component(at, plane.second);
        return along(plane.first, decay * std::sin(x) * std::cos(y)) +
               along(plane.second, -decay * std::cos(x) * std::sin(y));
    };
}

FlowConstants square(int n, const Plane& plane, FluidBoundary boundary) {
    FlowConstants c{.grid = {.cells = {4, 4, 4}, .h = (boundary == FluidBoundary::periodic ? 2.0 : 1.0) / n},
                    .kinematic_viscosity = 0.1};
    for (const int d : {plane.first, plane.second}) {
        nth(c.grid.cells, d) = n;
        nth(c.grid.boundary, d) = boundary;
    }
    return c;
}

/// In a period and between walls that do not rub, in each plane: the velocity of second order in step and grid
/// together, and the pressure, which is that of the middle of a step.
TEST_F(CrankNicolson, VorticesDecay) {
    constexpr double duration = 0.5;
    for (const FluidBoundary boundary : {FluidBoundary::periodic, FluidBoundary::free_slip})
        for (const Plane& plane : planes) {
            double error[2], pressure[2];
            for (int fine = 0; fine < 2; ++fine) {
                const int n = 32 << fine, steps = 10 << fine;
                const FlowConstants constants = square(n, plane, boundary);
                const double step = duration / steps, nu = constants.kinematic_viscosity;
                EXPECT_GT(nu * step / (constants.grid.h * constants.grid.h), 1.2); // rk3: 0.21
                const auto decay = [&](double t) { return std::exp(-2 * nu * pi * pi * t); };
                auto flow = flow_of(constants, vortices(plane, 1));
                advance(*flow, duration, steps);
                error[fine] = largest_error(*flow, vortices(plane, decay(duration)));
                pressure[fine] = 0;
                const double square_of = std::pow(decay(duration - 0.5 * step), 2);
                std::vector<double> less;
                for_places(*flow, 3, [&](double p, const Vec3d& at) {
                    const double x = 2 * pi * component(at, plane.first), y = 2 * pi * component(at, plane.second);
                    less.push_back(p - 0.25 * square_of * (std::cos(x) + std::cos(y)));
                });
                pressure[fine] = largest_but_for_mean(less);
            }
            EXPECT_GT(order(error[0], error[1]), 1.9);
            EXPECT_LT(error[1], 1e-3);
            EXPECT_GT(order(pressure[0], pressure[1]), 1.9);
            EXPECT_LT(pressure[1], 1e-3);
        }
}

/// The same with 60 h^2 / nu: of second order in the step alone.
TEST_F(CrankNicolson, IsOfSecondOrderInStepsFarBeyondViscosity) {
    const FlowConstants constants = square(128, planes[0], FluidBoundary::periodic);
    std::vector<double> ends[3][2];
    for (int i = 0; i < 3; ++i) {
        auto flow = flow_of(constants, vortices(planes[0], 1));
        const int steps = i == 2 ? 160 : 5 << i;
        advance(*flow, 0.75, steps);
        for (int c = 0; c < 2; ++c) ends[i][c] = values_of(*flow, c);
        EXPECT_GT(constants.kinematic_viscosity * 0.75 / steps / std::pow(constants.grid.h, 2), i == 0 ? 60 : 1);
    }
    for (const int c : {0, 1})
        EXPECT_GT(order(largest_difference(ends[0][c], ends[2][c]), largest_difference(ends[1][c], ends[2][c])), 1.9)
            << c;
}

/// A sine of half a period decays between walls at rest, whatever lies across and along.
TEST_F(CrankNicolson, ShearDecaysBetweenWalls) {
    for (int across = 0; across < 3; ++across)
        for (int c = 0; c < 3; ++c) {
            if (c == across) continue;
            double error[2];
            for (int fine = 0; fine < 2; ++fine) {
                const int n = 16 << fine;
                FlowConstants constants{.grid = {.cells = {4, 4, 4}, .h = 1.0 / n}, .kinematic_viscosity = 0.1};
                nth(constants.grid.cells, across) = n;
                nth(constants.grid.boundary, across) = FluidBoundary::no_slip;
                const auto sine = [&](double decay) {
                    return [=](const Vec3d& at) { return along(c, decay * std::sin(pi * component(at, across))); };
                };
                auto flow = flow_of(constants, sine(1));
                advance(*flow, 0.4, 10 << fine);
                error[fine] = largest_error(*flow, sine(std::exp(-0.1 * pi * pi * 0.4)));
            }
            EXPECT_GT(order(error[0], error[1]), 1.9) << across << c;
            EXPECT_LT(error[1], 1e-3);
        }
}

/// The steady profile between walls at rest is that of the discrete equations, a parabola and h^2 / 4.
TEST_F(CrankNicolson, FlowBetweenWallsIsAParabola) {
    for (int across = 0; across < 3; ++across) {
        const int c = (across + 1) % 3, n = 20;
        FlowConstants constants{
            .grid = {.cells = {4, 4, 4}, .h = 0.05}, .kinematic_viscosity = 0.3, .acceleration = along(c, 0.7)};
        nth(constants.grid.cells, across) = n;
        nth(constants.grid.boundary, across) = FluidBoundary::no_slip;
        auto flow = flow_of(constants, [](const Vec3d&) { return Vec3d{0, 0, 0}; });
        constexpr int steps = 400;
        advance(*flow, steps * 8 * 0.05 * 0.05 / 0.3, steps); // 8 h^2 / nu each
        const auto profile = [&](const Vec3d& at) {
            const double z = component(at, across);
            return along(c, 0.7 / (2 * 0.3) * (z * (1 - z) + 0.25 * 0.05 * 0.05));
        };
        EXPECT_LT(largest_error(*flow, profile), 1e-12);
    }
}

/// Between two pairs of walls at rest, 1 m apart, of flow along x.
double duct(double a, double nu, double y, double z) {
    double u = y * (1 - y) / 2;
    for (int m = 1; m < 60; m += 2)
        u -= 4 / std::pow(pi * m, 3) * std::sin(pi * m * y) * std::cosh(pi * m * (z - 0.5)) / std::cosh(pi * m * 0.5);
    return a / nu * u;
}

TEST_F(CrankNicolson, FlowInADuctIsThatOfTheSeries) {
    double error[2];
    for (int fine = 0; fine < 2; ++fine) {
        const int n = 16 << fine;
        const FluidBoundary wall = FluidBoundary::no_slip;
        FlowConstants constants{
            .grid = {.cells = {4, n, n}, .h = 1.0 / n, .boundary = {FluidBoundary::periodic, wall, wall}},
            .kinematic_viscosity = 0.2,
            .acceleration = {0.5, 0, 0}};
        auto flow = flow_of(constants, [](const Vec3d&) { return Vec3d{0, 0, 0}; });
        advance(*flow, 4, 160);
        error[fine] = largest_error(*flow, [](const Vec3d& at) { return Vec3d{duct(0.5, 0.2, at.y, at.z), 0, 0}; });
    }
    EXPECT_GT(order(error[0], error[1]), 1.9);
    EXPECT_LT(error[1], 2e-3 * duct(0.5, 0.2, 0.5, 0.5));
}

/// A vortex in a box whose walls are at rest: velocity and pressure of second order in the step.
TEST_F(CrankNicolson, IsOfSecondOrderInABoxWithFriction) {
    constexpr int n = 32;
    const FluidBoundary wall = FluidBoundary::no_slip;
    const FlowConstants constants{
        .grid = {.cells = {n, n, 4}, .h = 1.0 / n, .boundary = {wall, wall, FluidBoundary::periodic}},
        .kinematic_viscosity = 0.05};
    const auto start = [](const Vec3d& at) {
        const double x = pi * at.x, y = pi * at.y;
        return Vec3d{std::pow(std::sin(x), 2) * std::sin(2 * y), -std::sin(2 * x) * std::pow(std::sin(y), 2), 0};
    };
    std::vector<double> ends[3][4]; // of the pressure by the last two, which are those of middles of steps
    for (int i = 0; i < 3; ++i) {
        auto flow = flow_of(constants, start);
        const int steps = i == 2 ? 640 : 20 << i;
        for (int s = 0; s < steps; ++s) {
            flow->step(0.4 * s / steps, 0.4 / steps);
            if (s == steps - 2) ends[i][3] = values_of(*flow, 3);
        }
        for (int c = 0; c < 2; ++c) ends[i][c] = values_of(*flow, c);
        const std::vector<double> last = values_of(*flow, 3);
        for (std::size_t n = 0; n < last.size(); ++n) ends[i][3][n] = 1.5 * last[n] - 0.5 * ends[i][3][n];
    }
    for (const int c : {0, 1, 3}) {
        const double coarse = largest_difference(ends[0][c], ends[2][c]),
                     fine = largest_difference(ends[1][c], ends[2][c]);
        EXPECT_GT(order(coarse, fine), 1.9) << c;
    }
}

/// Steps of 10^4 h^2 / nu: a start at once dies out and does not swing.
TEST_F(CrankNicolson, AnyStepIsStable) {
    const FluidBoundary wall = FluidBoundary::no_slip;
    const FlowConstants constants{
        .grid = {.cells = {16, 16, 16}, .h = 1.0 / 16, .boundary = {FluidBoundary::periodic, wall, wall}},
        .kinematic_viscosity = 1e3};
    auto flow = flow_of(constants, [](const Vec3d& at) { return Vec3d{0.1, 0.1 * std::sin(2 * pi * at.x), 0}; });
    const double energy = figures_of(Communicator::alone(), *flow).kinetic_energy;
    const double step = 1e4 * std::pow(constants.grid.h, 2) / constants.kinematic_viscosity;
    EXPECT_GE(flow->step_limit(0.5), step);
    flow->step(0, step);
    for (int s = 1; s < 20; ++s) {
        flow->step(step * s, step);
        EXPECT_LT(figures_of(Communicator::alone(), *flow).kinetic_energy, 0.02 * energy);
    }
}

} // namespace
} // namespace skein
