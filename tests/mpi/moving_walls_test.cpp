// What walls that move and an acceleration that swings do to a fluid: closed forms between two plates, of second order
// in space and time, the same bits on any ranks; and a cavity under a lid.
#include "fluid/make_flow.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <vector>

namespace skein {
namespace {

using Complex = std::complex<double>;
constexpr double pi = std::numbers::pi;

Vec3d along(int direction, double value) {
    return {direction == 0 ? value : 0, direction == 1 ? value : 0, direction == 2 ? value : 0};
}
double component(const Vec3d& v, int direction) { return direction == 0 ? v.x : direction == 1 ? v.y : v.z; }

/// A flow between plates 1 m apart, along them: velocity at a share of the way across and a time.
struct Shear {
    double lower = 0, upper = 0, acceleration = 0, frequency = 0; // of plates, m/s; m/s^2; Hz
    std::function<double(double s, double t)> velocity;
};
constexpr double viscosity = 0.2; // m^2/s

/// Of a wave exp(i omega t): its number across the plates, times (1 + i).
Complex wave_number(double omega) { return Complex(1, 1) * std::sqrt(omega / (2 * viscosity)); }

/// Stokes' second problem between two plates that swing.
Shear swinging_plates() {
    Shear shear{.lower = 1, .upper = -0.5, .frequency = 0.5};
    shear.velocity = [=](double s, double t) {
        const double omega = 2 * pi * shear.frequency;
        const Complex k = wave_number(omega), wave = std::exp(Complex(0, omega * t)) / std::sinh(k);
        return (wave * (shear.lower * std::sinh(k * (1 - s)) + shear.upper * std::sinh(k * s))).real();
    };
    return shear;
}
/// Womersley's flow between plates at rest.
Shear swinging_fluid() {
    Shear shear{.acceleration = 2, .frequency = 0.5};
    shear.velocity = [=](double s, double t) {
        const double omega = 2 * pi * shear.frequency;
        const Complex k = wave_number(omega), profile = 1.0 - std::cosh(k * (s - 0.5)) / std::cosh(0.5 * k);
        return (shear.acceleration / Complex(0, omega) * std::exp(Complex(0, omega * t)) * profile).real();
    };
    return shear;
}
/// Couette's flow from rest on.
Shear starting_plates() {
    Shear shear{.lower = 0.3, .upper = 1};
    shear.velocity = [=](double s, double t) {
        if (t == 0) return 0.0;
        double sum = shear.lower + (shear.upper - shear.lower) * s;
        for (int n = 1; n < 200; ++n)
            sum += 2 / (n * pi) * (shear.upper * (n % 2 ? -1 : 1) - shear.lower) * std::sin(n * pi * s) *
                   std::exp(-n * n * pi * pi * viscosity * t);
        return sum;
    };
    return shear;
}

FlowConstants between_plates(const Shear& shear, int across, int stream, int n, FlowScheme scheme) {
    FlowConstants c{.grid = {.cells = {4, 4, 8}, .h = 1.0 / n}, .kinematic_viscosity = viscosity, .scheme = scheme};
    const auto d = static_cast<std::size_t>(across);
    c.grid.cells[d] = n;
    c.grid.boundary[d] = FluidBoundary::no_slip;
    c.wall_velocity[d] = {along(stream, shear.lower), along(stream, shear.upper)};
    c.acceleration = along(stream, shear.acceleration);
    c.frequency = shear.frequency;
    return c;
}

constexpr double duration = 0.9; // s

std::unique_ptr<FlowSolver> run(const Communicator& comm, const FlowConstants& constants, const Shear& shear,
                                int across, int stream, int steps) {
    static const Threads threads(1);
    auto flow = make_flow(comm, threads, constants);
    flow->set_velocity([&](const Vec3d& at) { return along(stream, shear.velocity(component(at, across), 0)); });
    for (int s = 0; s < steps; ++s) flow->step(s * duration / steps, duration / steps);
    return flow;
}

/// body(velocity along the plates, share of the way across) of all own cells.
template <class Body> void for_cells(const FlowSolver& flow, int across, int stream, Body&& body) {
    const FieldLayout layout = flow.layout();
    for (int k = 0; k < layout.nz; ++k)
        for (int j = 0; j < layout.ny; ++j)
            for (int i = 0; i < layout.nx; ++i) {
                const Vec3d place =
                    flow.constants().grid.h * Vec3d{i + 0.5, j + 0.5, flow.pencils().planes().first + k + 0.5};
                body(nth(flow.velocity(stream), layout.at(i, j, k)), component(place, across));
            }
}

/// Of all cells, one component after the other.
std::vector<double> velocities(const Communicator& comm, const FlowSolver& flow) {
    std::vector<double> all;
    for (int c = 0; c < 3; ++c) {
        std::vector<double> mine;
        for_cells(flow, 0, c, [&](double u, double) { mine.push_back(u); });
        const std::vector<double> of_component = comm.all_gather(mine);
        all.insert(all.end(), of_component.begin(), of_component.end());
    }
    return all;
}

/// Root mean square: the largest moves between the middles of cells near a wall.
double error_of(const Communicator& comm, const FlowSolver& flow, const Shear& shear, int across, int stream) {
    std::vector<double> mine;
    for_cells(flow, across, stream, [&](double u, double s) { mine.push_back(u - shear.velocity(s, duration)); });
    double sum = 0;
    const std::vector<double> all = comm.all_gather(mine);
    for (const double error : all) sum += error * error;
    return std::sqrt(sum / static_cast<double>(all.size()));
}

/// With what errors at 32 cells are less than.
const std::pair<Shear, double> shears[] = {
    {swinging_plates(), 6e-4}, {swinging_fluid(), 5e-4}, {starting_plates(), 2e-4}};

/// Across and along any directions, from 16 cells in `steps` steps to 32 in `times` as many, and with the same bits on
/// one rank. Errors at 32 cells are less than so much of their bounds.
void expect_second_order(FlowScheme scheme, int steps, int times, double of_bound) {
    const Communicator comm = Communicator::world();
    for (const auto& [shear, bound] : shears)
        for (int across = 0; across < 3; ++across)
            for (int stream = 0; stream < 3; ++stream) {
                if (stream == across) continue;
                double error[2];
                for (int fine = 0; fine < 2; ++fine) {
                    const FlowConstants constants = between_plates(shear, across, stream, 16 << fine, scheme);
                    const auto flow = run(comm, constants, shear, across, stream, fine ? times * steps : steps);
                    error[fine] = error_of(comm, *flow, shear, across, stream);
                    if (fine) continue;
                    const auto here = run(Communicator::alone(), constants, shear, across, stream, steps);
                    EXPECT_EQ(velocities(comm, *flow), velocities(Communicator::alone(), *here));
                }
                EXPECT_GT(std::log2(error[0] / error[1]), 1.95) << across << stream;
                EXPECT_LT(error[1], of_bound * bound) << across << stream;
            }
}

TEST(MovingWalls, AreOfSecondOrderWithImplicitViscosity) {
    // Steps of 2 and 4 h^2 / nu; the error of a plate that starts at once is 1.24 of its bound, in an eighth of the
    // steps.
    expect_second_order(FlowScheme::crank_nicolson, 20, 2, 1.5);
}
TEST(MovingWalls, AreOfSecondOrderAcrossAnyDirectionWithTheSameBits) { expect_second_order(FlowScheme::rk3, 80, 4, 1); }

TEST(MovingWalls, AreOfSecondOrderInTime) {
    if (!Communicator::world().root()) return; // by itself
    const Communicator alone = Communicator::alone();
    for (const FlowScheme scheme :
         {FlowScheme::rk3, FlowScheme::rk3_projected, FlowScheme::adams_bashforth, FlowScheme::crank_nicolson})
        for (const auto& [shear, bound] : shears) {
            if (shear.frequency == 0) continue; // begins with a jump
            const FlowConstants constants = between_plates(shear, 2, 0, 16, scheme);
            const std::vector<double> exact = velocities(alone, *run(alone, constants, shear, 2, 0, 3200));
            double error[2] = {0, 0};
            for (int fine = 0; fine < 2; ++fine) {
                const std::vector<double> u = velocities(alone, *run(alone, constants, shear, 2, 0, 200 << fine));
                for (std::size_t i = 0; i < u.size(); ++i)
                    error[fine] = std::max(error[fine], std::abs(u[i] - exact[i]));
            }
            EXPECT_GT(std::log2(error[0] / error[1]), 1.95) << nth(flow_scheme_names, scheme);
        }
}

/// Poiseuille's flow comes in, and goes through a channel as it came.
TEST(Channel, KeepsAParabolicInflow) {
    const Communicator comm = Communicator::world();
    const auto poiseuille = [](double s) { return 6 * s * (1 - s); };
    double error[2];
    for (int fine = 0; fine < 2; ++fine) {
        const int n = 16 << fine;
        FlowConstants constants{
            .grid = {.cells = {2 * n, n, 8}, .h = 1.0 / n}, .kinematic_viscosity = viscosity, .inflow = {1, 0, 0}};
        constants.grid.boundary = {FluidBoundary::through, FluidBoundary::no_slip, FluidBoundary::periodic};
        constants.inflow_profile = InflowProfile::parabolic;
        double mean = 0;
        for (int j = 0; j < n; ++j) mean += inflow_share(constants, j, 0) / n;
        EXPECT_NEAR(mean, 1, 1e-14);
        EXPECT_EQ(largest_inflow_share(constants), 1.5);
        const auto channel = [&](const Communicator& ranks) {
            static const Threads threads(1);
            auto flow = make_flow(ranks, threads, constants);
            flow->set_velocity([&](const Vec3d& at) { return Vec3d{poiseuille(at.y), 0, 0}; });
            for (int s = 0; s < 40; ++s) flow->step_within(0.01 * s, 0.01, 0.5);
            return flow;
        };
        const auto flow = channel(comm);
        error[fine] = 0;
        for_cells(*flow, 1, 0,
                  [&](double u, double s) { error[fine] = std::max(error[fine], std::abs(u - poiseuille(s))); });
        error[fine] = comm.max(error[fine]);
        if (fine) continue;
        EXPECT_EQ(velocities(comm, *flow), velocities(Communicator::alone(), *channel(Communicator::alone())));
    }
    EXPECT_LT(error[1], 2.0 / (32 * 32));
    EXPECT_GT(std::log2(error[0] / error[1]), 1.9);
}

/// An acceleration along a period acts on all of the fluid alike: as its integral, but for rounding.
TEST(MovingWalls, AnAccelerationThatSwingsGivesItsIntegral) {
    const Threads threads(1);
    FlowConstants constants{.grid = {.cells = {8, 8, 8}, .h = 0.1}, .acceleration = {1, -2, 0.5}, .frequency = 0.3};
    for (const FlowScheme scheme : {FlowScheme::rk3, FlowScheme::adams_bashforth}) {
        constants.scheme = scheme;
        auto flow = make_flow(Communicator::alone(), threads, constants);
        flow->set_velocity([](const Vec3d&) { return Vec3d{0, 0, 0}; });
        for (int s = 0; s < 5; ++s) flow->step(0.2 * s, 0.2);
        for (int c = 0; c < 3; ++c) {
            const double expected = component(constants.acceleration, c) * std::sin(2 * pi * 0.3) / (2 * pi * 0.3);
            for_cells(*flow, 0, c, [&](double u, double) { EXPECT_NEAR(u, expected, 1e-14); });
        }
    }
}

/// A step is a fortieth of a period at most, and knows of walls that have not set the fluid in motion yet.
TEST(MovingWalls, LimitTheStep) {
    FlowConstants constants = between_plates(swinging_plates(), 2, 0, 16, FlowScheme::rk3);
    constants.kinematic_viscosity = 0;
    EXPECT_DOUBLE_EQ(step_limit(constants, 0, 0.5), 0.5 / 16);
    constants.frequency = 10;
    EXPECT_DOUBLE_EQ(step_limit(constants, 0, 0.5), 0.1 / 40);
    constants.frequency = 0;
    EXPECT_DOUBLE_EQ(step_limit(constants, 2, 0.5), 0.25 / 16);
}

/// Velocities on the middle lines of a square cavity under a lid at Re = 100, of Ghia, Ghia and Shin 1982, tables I and
/// II.
TEST(MovingWalls, DriveACavity) {
    if (!Communicator::world().root()) return; // by itself
    constexpr int n = 32;
    const Threads threads(1);
    FlowConstants constants{.grid = {.cells = {n, 4, n}, .h = 1.0 / n}, .kinematic_viscosity = 0.01};
    constants.grid.boundary = {FluidBoundary::no_slip, FluidBoundary::periodic, FluidBoundary::no_slip};
    constants.wall_velocity[2][1] = {1, 0, 0};
    auto flow = make_flow(Communicator::alone(), threads, constants);
    flow->set_velocity([](const Vec3d&) { return Vec3d{0, 0, 0}; });
    flow->step_within(0, 20, 1);
    const FieldLayout layout = flow->layout();
    /// Between cells along a line, at a place in m; of faces in the middle across it.
    const auto at = [&](int c, double place) {
        const double cell = place * n - 0.5;
        const int i = static_cast<int>(cell);
        const auto value = [&](int of) {
            return nth(flow->velocity(c), c == 0 ? layout.at(n / 2 - 1, 1, of) : layout.at(of, 1, n / 2 - 1));
        };
        return value(i) + (cell - i) * (value(i + 1) - value(i));
    };
    const std::pair<double, double> u[] = {{0.1719, -0.10150}, {0.2813, -0.15662}, {0.4531, -0.21090},
                                           {0.5, -0.20581},    {0.6172, -0.13641}, {0.7344, 0.00332},
                                           {0.8516, 0.23151},  {0.9531, 0.68717}},
                                    w[] = {{0.0938, 0.12317},
                                           {0.2344, 0.17527},
                                           {0.5, 0.05454},
                                           {0.8047, -0.24533},
                                           {0.9063, -0.16914}};
    for (const auto& [place, expected] : u) EXPECT_NEAR(at(0, place), expected, 0.008) << place;
    for (const auto& [place, expected] : w) EXPECT_NEAR(at(2, place), expected, 0.008) << place;
}

} // namespace
} // namespace skein
