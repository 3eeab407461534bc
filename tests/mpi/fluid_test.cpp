// The fluid on any number of ranks: what it solves, of what order, and the same bits.
#include "fluid/fast_helmholtz.hpp"
#include "fluid/make_flow.hpp"
#include "fluid/pressure_gain.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

std::size_t count_of(const FluidGrid& grid) { return static_cast<std::size_t>(grid.count()); }

/// Of all cells, x fastest, z slowest, with sum 0.
std::vector<double> random_numbers(const FluidGrid& grid) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<double> all(count_of(grid));
    double sum = 0;
    for (double& x : all) sum += x = normal(random);
    for (double& x : all) x -= sum / static_cast<double>(all.size());
    return all;
}

/// Ways to share the rows of slabs among so many ranks.
std::vector<int> ways_across(int ranks) {
    std::vector<int> all;
    for (int across = 1; across <= ranks; ++across)
        if (ranks % across == 0) all.push_back(across);
    return all;
}

/// Of all cells, fields one after the other in each plane, from what ranks have in that order.
std::vector<double> in_order(const Communicator& comm, const FluidGrid& grid, int across,
                             const std::vector<double>& mine) {
    const std::vector<double> come = comm.all_gather(mine);
    const std::size_t fields = come.size() / count_of(grid);
    std::vector<double> all(come.size());
    auto from = come.begin();
    for (int r = 0; r < comm.size(); ++r) {
        const Pencils pencils(grid, r, comm.size(), across);
        const auto [nx, ny, nz] = grid.cells;
        for (int k = 0; k < pencils.planes().count; ++k)
            for (std::size_t f = 0; f < fields; ++f)
                for (int j = 0; j < pencils.rows().count; ++j, from += nx) {
                    const std::size_t plane = static_cast<std::size_t>(pencils.planes().first + k) * fields + f,
                                      row = plane * static_cast<std::size_t>(ny) +
                                            static_cast<std::size_t>(pencils.rows().first + j);
                    std::copy_n(from, nx, all.begin() + static_cast<std::ptrdiff_t>(row) * nx);
                }
    }
    return all;
}

std::vector<double> solved(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                           const Helmholtz& equation, const std::vector<double>& f,
                           ColumnExchange exchange = ColumnExchange::transposes, int across = 1) {
    const Pencils pencils(grid, comm.rank(), comm.size(), across);
    FastHelmholtz solver(comm, threads, grid, pencils, exchange);
    const FieldLayout layout = pencils.layout();
    AlignedVector<double> field(layout.size(), 0.0);
    const auto for_cells = [&](auto&& body) {
        for (int k = 0; k < layout.nz; ++k)
            for (int j = 0; j < layout.ny; ++j)
                for (int i = 0; i < layout.nx; ++i) body(static_cast<std::size_t>(layout.at(i, j, k)), i, j, k);
    };
    for_cells([&](std::size_t at, int i, int j, int k) {
        const int row = (k + pencils.planes().first) * grid.cells[1] + j + pencils.rows().first;
        field[at] = nth(f, row * layout.nx + i);
    });
    // In place, as the fluid does it.
    solver.solve(
        equation, [&](int i, int j, int k) { return load<8>(&nth(field, layout.at(i, j, k))); },
        [&](int i, int j, int k, const Pack<8>& p) { store(&nth(field, layout.at(i, j, k)), p); });
    std::vector<double> mine;
    for_cells([&](std::size_t at, int, int, int) { mine.push_back(field[at]); });
    return in_order(comm, grid, across, mine);
}

/// The largest difference of (second differences + shift) phi and scale f.
double residual(const FluidGrid& grid, const std::array<LineEnds, 3>& ends, const Helmholtz& equation,
                const std::vector<double>& phi, const std::vector<double>& f) {
    const auto at = [&](std::array<int, 3> c) {
        double sign = 1;
        for (std::size_t d = 0; d < 3; ++d) {
            const int n = grid.cells[d], inside = std::clamp(c[d], 0, n - 1);
            if (ends[d] == LineEnds::faces_zero && (c[d] < 0 || c[d] >= n - 1)) return 0.0;
            if (ends[d] == LineEnds::value_zero && inside != c[d]) sign = -sign;
            c[d] = ends[d] == LineEnds::periodic ? (c[d] + n) % n : inside;
        }
        return sign * nth(phi, (c[2] * grid.cells[1] + c[1]) * grid.cells[0] + c[0]);
    };
    double most = 0;
    std::size_t cell = 0;
    for (int k = 0; k < grid.cells[2]; ++k)
        for (int j = 0; j < grid.cells[1]; ++j)
            for (int i = 0; i < grid.cells[0]; ++i, ++cell) {
                const std::array<int, 3> here{i, j, k};
                bool known = false; // a wall
                for (std::size_t d = 0; d < 3; ++d)
                    known |= ends[d] == LineEnds::faces_zero && here[d] == grid.cells[d] - 1;
                if (known) {
                    most = std::max(most, std::abs(phi[cell]));
                    continue;
                }
                const double around = at({i - 1, j, k}) + at({i + 1, j, k}) + at({i, j - 1, k}) + at({i, j + 1, k}) +
                                      at({i, j, k - 1}) + at({i, j, k + 1});
                most = std::max(most, std::abs(around + (equation.shift - 6) * phi[cell] - equation.scale * f[cell]));
            }
    return most;
}

double largest_of(const std::vector<double>& all) {
    double most = 0;
    for (const double x : all) most = std::max(most, std::abs(x));
    return most;
}
double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> difference(a.size());
    std::transform(a.begin(), a.end(), b.begin(), difference.begin(), std::minus());
    return largest_of(difference);
}

FluidGrid grid_of(std::array<int, 3> cells, unsigned walls, FluidBoundary wall = FluidBoundary::free_slip) {
    FluidGrid grid{.cells = cells, .h = 0.1};
    for (std::size_t d = 0; d < 3; ++d) grid.boundary[d] = walls >> d & 1 ? wall : FluidBoundary::periodic;
    return grid;
}

std::array<LineEnds, 3> pressure_ends(unsigned walls) {
    std::array<LineEnds, 3> ends;
    for (std::size_t d = 0; d < 3; ++d) ends[d] = walls >> d & 1 ? LineEnds::gradient_zero : LineEnds::periodic;
    return ends;
}

TEST(FastHelmholtz, SolvesPoissonsEquationWithTheSameBits) {
    const Communicator comm = Communicator::world();
    const Threads threads(1), team(2);
    for (unsigned walls = 0; walls < 8; ++walls)
        for (const std::array<int, 3> cells :
             {std::array{24, 20, 18}, std::array{21, 15, 7}, std::array{16, 35, 2}, std::array{9, 8, 1}}) {
            const FluidGrid grid = grid_of(cells, walls);
            const Helmholtz equation = Helmholtz::of_pressure(grid);
            const std::vector<double> f = random_numbers(grid), phi = solved(comm, threads, grid, equation, f);
            EXPECT_LT(residual(grid, pressure_ends(walls), equation, phi, f), 1e-14)
                << "walls " << walls << " cells " << cells[0];
            EXPECT_EQ(phi, solved(Communicator::alone(), threads, grid, equation, f));
            EXPECT_EQ(phi, solved(comm, team, grid, equation, f));
            for (const int across : ways_across(comm.size()))
                EXPECT_EQ(phi, solved(comm, team, grid, equation, f, ColumnExchange::transposes, across))
                    << "walls " << walls << " cells " << cells[0] << " across " << across;
        }
}

TEST(FastHelmholtz, SendsEachNumberOnceToEachTransform) {
    const Communicator comm = Communicator::world();
    const Threads threads(1);
    const FluidGrid grid = grid_of({96, 48, 24}, 0);
    const Helmholtz equation = Helmholtz::of_pressure(grid);
    for (const int across : ways_across(comm.size())) {
        const Pencils pencils(grid, comm.rank(), comm.size(), across);
        FastHelmholtz solver(comm, threads, grid, pencils);
        const std::int64_t before = Communicator::traffic().bytes;
        solver.solve(
            equation, [](int, int, int) { return Pack<8>(1.0); }, [](int, int, int, const Pack<8>&) {});
        const auto slabs = comm.size() / across, own = static_cast<int>(grid.count()) / comm.size();
        EXPECT_EQ(Communicator::traffic().bytes - before,
                  16 * (own / across * (across - 1) + own / slabs * (slabs - 1)));
    }
}

/// Of a velocity: (1 - b second differences) phi = f.
TEST(FastHelmholtz, SolvesForAnyEndsWithTheSameBits) {
    const Communicator comm = Communicator::world();
    const Threads threads(1), team(2);
    constexpr LineEnds kinds[] = {LineEnds::periodic, LineEnds::gradient_zero, LineEnds::value_zero,
                                  LineEnds::faces_zero};
    for (unsigned which = 0; which < 64; ++which)
        for (const double b : {0.05, 25.0, 1e4}) {
            const std::array<LineEnds, 3> ends{kinds[which % 4], kinds[which / 4 % 4], kinds[which / 16]};
            const FluidGrid grid = grid_of(b < 1 ? std::array{24, 20, 9} : std::array{21, 15, 8}, which < 16 ? 0 : 4);
            Helmholtz equation(grid, ends);
            equation.shift = equation.scale = -1 / b;
            const std::vector<double> f = random_numbers(grid), phi = solved(comm, threads, grid, equation, f),
                                      slabs = solved(comm, threads, grid, equation, f, ColumnExchange::interfaces);
            EXPECT_LT(b * residual(grid, ends, equation, phi, f), 1e-12) << "ends " << which << " b " << b;
            EXPECT_LT(b * residual(grid, ends, equation, slabs, f), 1e-12) << "ends " << which << " b " << b;
            EXPECT_LT(largest_difference(slabs, phi), 1e-12 * largest_of(phi)) << "ends " << which << " b " << b;
            if (b != 25) continue;
            for (const int across : ways_across(comm.size()))
                EXPECT_EQ(phi, solved(comm, threads, grid, equation, f, ColumnExchange::transposes, across))
                    << "ends " << which << " b " << b << " across " << across;
            EXPECT_EQ(phi, solved(Communicator::alone(), threads, grid, equation, f));
            EXPECT_EQ(phi, solved(comm, team, grid, equation, f));
        }
}

/// Slabs that are thick and thin: coefficients that reach across all of them, and others.
TEST(SlabColumns, FindWhatWholeColumnsFindButForRounding) {
    const Communicator comm = Communicator::world();
    const Threads threads(1), team(2);
    for (unsigned walls = 0; walls < 8; ++walls)
        for (const std::array<int, 3> cells : {std::array{24, 20, 18}, std::array{21, 15, 9}, std::array{16, 35, 100},
                                               std::array{5, 8, 245}, std::array{9, 8, 2 * comm.size()}}) {
            const FluidGrid grid = grid_of(cells, walls);
            const Helmholtz equation = Helmholtz::of_pressure(grid);
            const std::vector<double> f = random_numbers(grid), whole = solved(comm, threads, grid, equation, f),
                                      phi = solved(comm, threads, grid, equation, f, ColumnExchange::interfaces);
            EXPECT_LT(residual(grid, pressure_ends(walls), equation, phi, f), 1e-12 * equation.scale * largest_of(f))
                << "walls " << walls << " cells " << cells[0];
            EXPECT_LT(largest_difference(phi, whole), 1e-12 * largest_of(whole))
                << "walls " << walls << " cells " << cells[0];
            EXPECT_EQ(phi, solved(comm, team, grid, equation, f, ColumnExchange::interfaces));
            for (const int across : ways_across(comm.size()))
                EXPECT_LT(largest_difference(
                              solved(comm, threads, grid, equation, f, ColumnExchange::interfaces, across), whole),
                          1e-12 * largest_of(whole))
                    << "walls " << walls << " cells " << cells[0] << " across " << across;
        }
}

constexpr FlowScheme all_schemes[] = {FlowScheme::rk3, FlowScheme::rk3_projected, FlowScheme::adams_bashforth,
                                      FlowScheme::crank_nicolson};

FlowConstants vortices(int n, FlowScheme scheme) {
    FlowConstants c;
    c.grid = {.cells = {n, n, 8}, .h = 2 * pi / n};
    c.kinematic_viscosity = 0.01;
    c.density = 2;
    c.scheme = scheme;
    return c;
}
/// Of Taylor and Green in two dimensions, carried along by a stream.
Vec3d vortex(const Vec3d& at, double t, const Vec3d& stream) {
    const double x = at.x - stream.x * t, y = at.y - stream.y * t, decay = std::exp(-0.02 * t);
    return stream + decay * Vec3d{-std::cos(x) * std::sin(y), std::sin(x) * std::cos(y), 0};
}

/// Largest error of u after 1 s in so many steps, on each rank by itself.
double error_after(const FlowConstants& constants, int steps, const Vec3d& stream, bool against_itself = false) {
    const Communicator comm = Communicator::alone();
    const Threads threads(1);
    const auto run = [&](int n) {
        auto flow = make_flow(comm, threads, constants);
        flow->set_velocity([&](const Vec3d& at) { return vortex(at, 0, stream); });
        for (int s = 0; s < n; ++s) flow->step(0, 1.0 / n);
        return flow;
    };
    const auto flow = run(steps), fine = against_itself ? run(8 * steps) : nullptr;
    const FieldLayout layout = flow->layout();
    double most = 0;
    for (int k = 0; k < layout.nz; ++k)
        for (int j = 0; j < layout.ny; ++j)
            for (int i = 0; i < layout.nx; ++i) {
                const auto at = static_cast<std::size_t>(layout.at(i, j, k));
                const double exact =
                    fine ? fine->velocity(0)[at] : vortex(constants.grid.h * Vec3d{i + 1.0, j + 0.5, 0}, 1, stream).x;
                most = std::max(most, std::abs(flow->velocity(0)[at] - exact));
            }
    return most;
}

TEST(Flow, IsOfSecondOrderInSpace) {
    for (const FlowScheme scheme : all_schemes) {
        double error[3];
        for (int i = 0; i < 3; ++i) error[i] = error_after(vortices(16 << i, scheme), 20 << i, {0, 0, 0});
        EXPECT_GT(std::log2(error[0] / error[1]), 1.95);
        EXPECT_GT(std::log2(error[1] / error[2]), 1.95);
        EXPECT_LT(error[2], 2e-5) << nth(flow_scheme_names, scheme);
    }
}

TEST(Flow, IsOfSecondOrderInTime) {
    for (const FlowScheme scheme : all_schemes) {
        const double coarse = error_after(vortices(16, scheme), 10, {1, 0.5, 0}, true),
                     fine = error_after(vortices(16, scheme), 20, {1, 0.5, 0}, true);
        EXPECT_GT(std::log2(coarse / fine), 1.95) << nth(flow_scheme_names, scheme);
    }
}

/// Pressure at 1 s after so many steps; `gain`: with what makes it that of the end of the last step.
std::vector<double> pressure_after(const FlowConstants& constants, int steps, bool gain) {
    const Threads threads(1);
    auto flow = make_flow(Communicator::alone(), threads, constants);
    pressure_in_time(*flow).keep_pressure_gain();
    flow->set_velocity([](const Vec3d& at) { return vortex(at, 0, {1, 0.5, 0}); });
    for (int s = 0; s < steps; ++s) flow->step(1.0 * s / steps, 1.0 / steps);
    const FieldLayout layout = flow->layout();
    const PressureInTime::Gain more = pressure_in_time(*flow).pressure_gain();
    EXPECT_NE(more.times, 0);
    std::vector<double> all;
    for (int j = 0; j < layout.ny; ++j)
        for (int i = 0; i < layout.nx; ++i) {
            const auto at = static_cast<std::size_t>(layout.at(i, j, 0));
            all.push_back(flow->pressure()[at] + (gain ? more.times * more.field[at] : 0));
        }
    return all;
}

/// The stream carries the pressure along, so that half a step shows.
TEST(Flow, ItsPressureIsOfSecondOrderInTimeWithTheGainOfTheLastStep) {
    for (const FlowScheme scheme : all_schemes)
        for (const bool gain : {true, false}) {
            const FlowConstants constants = vortices(16, scheme);
            const std::vector<double> exact = pressure_after(constants, 160, true);
            const double coarse = largest_difference(pressure_after(constants, 10, gain), exact),
                         fine = largest_difference(pressure_after(constants, 20, gain), exact),
                         order = std::log2(coarse / fine);
            const std::string_view name = nth(flow_scheme_names, scheme);
            if (gain) EXPECT_GT(order, 1.9) << name << ": " << coarse << ", " << fine;
            else EXPECT_LT(order, 1.5) << name << ": " << coarse << ", " << fine;
        }
}

/// Something in all directions, which boundaries of every kind allow.
Vec3d tangled(const Vec3d& at) {
    const double x = 2 * pi * at.x / 2.4, y = 2 * pi * at.y / 2, z = 2 * pi * at.z / 1.6;
    return {std::sin(x) * std::cos(y) * std::cos(z) + 0.3 * std::sin(2 * y),
            std::cos(2 * x) * std::sin(y) * std::cos(z), std::sin(z) * std::cos(y + x)};
}

std::vector<FlowConstants> all_kinds() {
    std::vector<FlowConstants> all;
    for (const FlowScheme scheme : all_schemes)
        for (const FluidBoundary wall : {FluidBoundary::free_slip, FluidBoundary::no_slip})
            for (unsigned walls = 0; walls < 8; ++walls) {
                const bool by_boundary =
                    scheme == FlowScheme::rk3 || scheme == FlowScheme::crank_nicolson; // others are as rk3
                if (!by_boundary && walls != 0 && walls != 6) continue;
                all.push_back({.grid = grid_of({24, 20, 16}, walls, wall),
                               .density = 3,
                               .kinematic_viscosity = 2e-3,
                               .scheme = scheme});
            }
    all.push_back(
        {.grid = grid_of({21, 21, 16}, 0), .kinematic_viscosity = 2e-3}); // rows end within a pack, and within a pair
    all.push_back({.grid = grid_of({24, 20, 2}, 2), .kinematic_viscosity = 2e-3}); // too thin for slabs
    FlowConstants through{.grid = grid_of({24, 20, 16}, 6), .kinematic_viscosity = 1e-2, .inflow = {1, 0.1, 0}};
    through.grid.boundary[0] = FluidBoundary::through;
    all.push_back(through);
    through.grid.boundary[2] = FluidBoundary::no_slip;
    through.scheme = FlowScheme::rk3_projected;
    all.push_back(through);
    for (const FlowScheme scheme : {FlowScheme::rk3, FlowScheme::adams_bashforth}) {
        FlowConstants moving{.grid = grid_of({24, 20, 16}, 7, FluidBoundary::no_slip), .kinematic_viscosity = 2e-3};
        moving.acceleration = {0.3, 0.2, 0.1};
        moving.frequency = 3;
        moving.scheme = scheme;
        for (std::size_t d = 0; d < 3; ++d)
            for (std::size_t side = 0; side < 2; ++side) {
                const double v = 0.5 + 0.3 * static_cast<double>(d) - static_cast<double>(side);
                moving.wall_velocity[d][side] = {d == 0 ? 0 : v, d == 1 ? 0 : -v, d == 2 ? 0 : v};
            }
        all.push_back(moving);
    }
    return all;
}

/// Velocities and pressure of this rank's own cells.
std::vector<double> fields_of(const FlowSolver& flow) {
    const FieldLayout layout = flow.layout();
    std::vector<double> all;
    for (int k = 0; k < layout.nz; ++k)
        for (const std::span<const double> field :
             {flow.velocity(0), flow.velocity(1), flow.velocity(2), flow.pressure()})
            for (int j = 0; j < layout.ny; ++j)
                for (int i = 0; i < layout.nx; ++i) all.push_back(nth(field, layout.at(i, j, k)));
    return all;
}

std::vector<double> after_steps(const Communicator& comm, const Threads& threads, const FlowConstants& constants) {
    auto flow = make_flow(comm, threads, constants);
    flow->set_velocity(tangled);
    for (int s = 0; s < 2; ++s) flow->step(0.02 * s, 0.02);
    return in_order(comm, constants.grid, flow->pencils().across(), fields_of(*flow));
}

TEST(Flow, HasTheSameBitsOnAnyRanksAndThreads) {
    const Threads threads(1), team(2);
    for (FlowConstants constants : all_kinds()) {
        const std::vector<double> here = after_steps(Communicator::world(), threads, constants);
        EXPECT_EQ(here, after_steps(Communicator::alone(), threads, constants));
        EXPECT_EQ(here, after_steps(Communicator::world(), team, constants));
        for (const int across : ways_across(Communicator::world().size())) {
            constants.ranks_across = across;
            if (across == 1 || !unshared(constants, Communicator::world().size()).empty()) continue;
            EXPECT_EQ(here, after_steps(Communicator::world(), threads, constants)) << across << " ranks across";
        }
    }
}

TEST(Pencils, HaveEachCellOnceAndAreRefusedWhereTheyAreTooThin) {
    const FluidGrid grid = grid_of({24, 21, 9}, 0);
    for (const auto& [ranks, across] : {std::pair{1, 1}, {4, 1}, {4, 2}, {20, 5}, {10, 10}, {40, 10}}) {
        EXPECT_EQ(unshared(grid, ranks, across), "");
        std::vector<int> of(21 * 9, -1), modes(24, -1);
        for (int r = 0; r < ranks; ++r) {
            const Pencils pencils(grid, r, ranks, across);
            EXPECT_GE(pencils.planes().count, ranks / across > 1 ? 2 : 9);
            EXPECT_GE(pencils.rows().count, across > 1 ? 2 : 21);
            for (int k = 0; k < pencils.planes().count; ++k)
                for (int j = 0; j < pencils.rows().count; ++j) {
                    const int row = pencils.rows().first + j, plane = pencils.planes().first + k;
                    EXPECT_EQ(std::exchange(nth(of, plane * 21 + row), r), -1);
                    EXPECT_EQ(pencils.rank_of_cell(row, plane), r);
                }
            if (pencils.slab() > 0) continue;
            const Slab own = pencils.modes(pencils.share());
            for (int m = 0; m < own.count; ++m) EXPECT_EQ(std::exchange(nth(modes, own.first + m), r), -1);
        }
        EXPECT_EQ(std::count(of.begin(), of.end(), -1), 0);
        EXPECT_EQ(std::count(modes.begin(), modes.end(), -1), 0);
    }
    EXPECT_EQ(fewest_across(grid, 4), 1);
    EXPECT_EQ(fewest_across(grid, 5), 5);
    EXPECT_EQ(fewest_across(grid, 6), 2);
    EXPECT_EQ(fewest_across(grid, 11), 0);
    EXPECT_EQ(fewest_across(grid, 40), 10);
    EXPECT_EQ(fewest_across(grid, 44), 0);
    EXPECT_NE(unshared(grid, 6, 4).find("expected a divisor of 6"), std::string::npos);
    EXPECT_NE(unshared(grid, 11, 11).find("expected at most 10"), std::string::npos);
    EXPECT_NE(unshared(grid, 10, 2).find("expected at most 4 slabs"), std::string::npos);
    EXPECT_NE(unshared(grid, 44, 0).find("too few for 44 ranks"), std::string::npos);
}

/// Columns slab by slab, of the pressure and of implicit viscosity: the flow of whole columns but for rounding, the
/// same bits on any threads and when it goes on from its state.
TEST(Flow, IsThatOfWholeColumnsSlabBySlab) {
    const Communicator comm = Communicator::world();
    const Threads threads(1), team(2);
    std::vector<FlowConstants> kinds = all_kinds();
    for (unsigned walls = 0; walls < 8; ++walls)
        kinds.push_back(
            {.grid = grid_of({24, 20, 16}, walls, walls == 5 ? FluidBoundary::free_slip : FluidBoundary::no_slip),
             .kinematic_viscosity = 0.5,
             .scheme = FlowScheme::crank_nicolson});
    for (FlowConstants constants : kinds) {
        const std::vector<double> whole = after_steps(comm, threads, constants);
        constants.exchange = ColumnExchange::interfaces;
        const std::vector<double> slabs = after_steps(comm, threads, constants);
        EXPECT_LT(largest_difference(slabs, whole), 1e-12 * largest_of(whole));
        EXPECT_EQ(slabs, after_steps(comm, team, constants));
    }
}

TEST(Flow, KeepsWhatItShould) {
    const Communicator comm = Communicator::world();
    const Threads threads(1);
    for (const FlowConstants& constants : all_kinds()) {
        if (constants.grid.boundary[0] == FluidBoundary::through || wall_speed(constants) > 0) continue;
        auto flow = make_flow(comm, threads, constants);
        flow->set_velocity(tangled);
        const FlowFigures before = figures_of(comm, *flow);
        double energy = before.kinetic_energy;
        for (int s = 0; s < 4; ++s) {
            flow->step(0, 0.01);
            const FlowFigures now = figures_of(comm, *flow);
            EXPECT_LT(now.kinetic_energy, energy * (1 + 1e-12));
            EXPECT_LT(now.divergence, 1e-12 * now.speed / constants.grid.h);
            energy = now.kinetic_energy;
        }
        const bool periodic = constants.grid.periodic(0) && constants.grid.periodic(1) && constants.grid.periodic(2);
        if (periodic) {
            const double size = std::sqrt(2 * energy * constants.density * 2.4 * 2 * 1.6);
            EXPECT_LT(norm(figures_of(comm, *flow).momentum - before.momentum), 1e-13 * size);
        }
    }
}

/// Loss of kinetic energy is the work of viscosity, of which sums of vorticity tell where nothing goes through the
/// boundary.
TEST(Flow, LosesEnergyByViscosityAlone) {
    const Communicator comm = Communicator::alone();
    const Threads threads(1);
    FlowConstants constants{
        .grid = {.cells = {32, 32, 32}, .h = 2 * pi / 32}, .density = 2, .kinematic_viscosity = 0.01};
    auto flow = make_flow(comm, threads, constants);
    flow->set_velocity([](const Vec3d& at) {
        return Vec3d{std::sin(at.x) * std::cos(at.y) * std::cos(at.z),
                     -std::cos(at.x) * std::sin(at.y) * std::cos(at.z), 0};
    });
    for (int s = 0; s < 40; ++s) flow->step(0, 0.02);
    const FlowFigures before = figures_of(comm, *flow);
    flow->step(0, 0.01);
    const FlowFigures between = figures_of(comm, *flow);
    flow->step(0, 0.01);
    const double loss = (before.kinetic_energy - figures_of(comm, *flow).kinetic_energy) / 0.02;
    EXPECT_NEAR(loss, between.dissipation, 2e-4 * loss);
    EXPECT_NEAR(between.dissipation, 2 * constants.density * constants.kinematic_viscosity * between.enstrophy,
                1e-12 * loss);
}

/// Between two walls at rest a sine of half a period decays; of second order.
TEST(Flow, ShearDecaysBetweenWalls) {
    const Communicator comm = Communicator::alone();
    const Threads threads(1);
    double error[2];
    for (int fine = 0; fine < 2; ++fine) {
        const int n = 16 << fine;
        FlowConstants constants{.grid = {.cells = {4, 4, n}, .h = 1.0 / n}, .kinematic_viscosity = 0.1};
        constants.grid.boundary[2] = FluidBoundary::no_slip;
        auto flow = make_flow(comm, threads, constants);
        flow->set_velocity([](const Vec3d& at) { return Vec3d{std::sin(pi * at.z), 0, 0}; });
        const int steps = 400 << fine;
        for (int s = 0; s < steps; ++s) flow->step(0, 0.4 / steps);
        const FieldLayout layout = flow->layout();
        double most = 0;
        for (int k = 0; k < layout.nz; ++k)
            most = std::max(most, std::abs(nth(flow->velocity(0), layout.at(1, 1, k)) -
                                           std::sin(pi * (flow->pencils().planes().first + k + 0.5) / n) *
                                               std::exp(-0.1 * pi * pi * 0.4)));
        error[fine] = most;
    }
    EXPECT_GT(std::log2(error[0] / error[1]), 1.95);
    EXPECT_LT(error[1], 1e-3);
}

TEST(Flow, StreamsThroughUnchanged) {
    const Communicator comm = Communicator::world();
    const Threads threads(1);
    FlowConstants constants{.grid = grid_of({24, 16, 16}, 6), .kinematic_viscosity = 1e-2, .inflow = {1, 0, 0}};
    constants.grid.boundary[0] = FluidBoundary::through;
    auto flow = make_flow(comm, threads, constants);
    flow->set_velocity([](const Vec3d&) { return Vec3d{1, 0, 0}; });
    for (int s = 0; s < 20; ++s) flow->step(0, 0.05);
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < flow->layout().nz; ++k)
            for (int i = 0; i < 24; ++i)
                EXPECT_NEAR(nth(flow->velocity(c), flow->layout().at(i, 7, k)), c == 0 ? 1 : 0, 1e-13);
}

TEST(Flow, GoesOnFromItsState) {
    const Communicator comm = Communicator::world();
    const Threads threads(1);
    for (const FlowConstants& constants : all_kinds()) {
        auto first = make_flow(comm, threads, constants), second = make_flow(comm, threads, constants);
        first->set_velocity(tangled);
        for (int s = 0; s < 2; ++s) first->step(0.02 * s, 0.02);
        const auto from = first->state(), to = second->state();
        for (std::size_t f = 0; f < from.size(); ++f)
            for (int k = 0; k < first->layout().nz; ++k)
                for (int j = 0; j < first->layout().ny; ++j) { // ghosts are not part of it
                    const auto row = static_cast<std::size_t>(first->layout().at(0, j, k));
                    std::memcpy(&to[f][row], &from[f][row],
                                static_cast<std::size_t>(first->layout().nx) * sizeof(double));
                }
        second->refresh(0.3); // of another time: a step begins at its own
        for (int s = 2; s < 4; ++s) {
            first->step(0.02 * s, 0.02);
            second->step(0.02 * s, 0.02);
        }
        EXPECT_EQ(fields_of(*first), fields_of(*second));
    }
}

} // namespace
} // namespace skein
