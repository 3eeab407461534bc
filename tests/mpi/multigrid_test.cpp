// Multigrid for the pressure on any number of ranks: against the direct solver on grids of cubes, against a closed form
// on others, and within steps of the fluid.
#include "fluid/fast_helmholtz.hpp"
#include "fluid/iterated_poisson.hpp"
#include "fluid/make_flow.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

FluidGrid grid_of(std::array<int, 3> cells, unsigned walls) {
    FluidGrid grid{.cells = cells, .h = 0.1};
    for (std::size_t d = 0; d < 3; ++d)
        grid.boundary[d] = walls >> d & 1 ? FluidBoundary::free_slip : FluidBoundary::periodic;
    return grid;
}

TensorGrid even(std::array<int, 3> cells, unsigned walls, double h) {
    TensorGrid grid;
    for (std::size_t d = 0; d < 3; ++d) {
        grid.width[d].assign(static_cast<std::size_t>(cells[d]), h);
        grid.periodic[d] = !(walls >> d & 1);
    }
    return grid;
}

/// Cells along a length of 1, those in the middle `stretch` times as wide as those at the ends: faces are a smooth
/// function of number.
std::vector<double> stretched(int n, double stretch) {
    const double bend = (stretch - 1) / (stretch + 1);
    const auto face = [&](int i) { return i / double(n) - bend * std::sin(2 * pi * i / n) / (2 * pi); };
    std::vector<double> width;
    for (int i = 0; i < n; ++i) width.push_back(face(i + 1) - face(i));
    return width;
}

std::array<int, 3> cells_of(const TensorGrid& grid) {
    return {static_cast<int>(grid.width[0].size()), static_cast<int>(grid.width[1].size()),
            static_cast<int>(grid.width[2].size())};
}

/// body(cell, i, j, k) for all cells, x fastest.
template <class Body> void for_cells(const TensorGrid& grid, Body&& body) {
    const auto [nx, ny, nz] = cells_of(grid);
    std::size_t cell = 0;
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) body(cell++, i, j, k);
}

double volume(const TensorGrid& grid, int i, int j, int k) {
    return nth(grid.width[0], i) * nth(grid.width[1], j) * nth(grid.width[2], k);
}

/// Less its mean over the box.
void centre(const TensorGrid& grid, std::vector<double>& f) {
    double sum = 0, whole = 0;
    for_cells(grid, [&](std::size_t cell, int i, int j, int k) {
        sum += volume(grid, i, j, k) * f[cell];
        whole += volume(grid, i, j, k);
    });
    for (double& x : f) x -= sum / whole;
}

std::vector<double> random_numbers(const TensorGrid& grid) {
    const auto [nx, ny, nz] = cells_of(grid);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<double> f(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz));
    for (double& x : f) x = normal(random);
    centre(grid, f);
    return f;
}

/// phi of all cells, by multigrid; empty, and the fault told, where there is none.
std::vector<double> solved(const Communicator& comm, const TensorGrid& grid, const std::vector<double>& f,
                           double tolerance, std::string* fault = nullptr) {
    const auto [nx, ny, nz] = cells_of(grid);
    const Slab slab = slab_of(nz, comm.rank(), comm.size());
    const auto plane = static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny);
    const auto mine = std::span(f).subspan(plane * static_cast<std::size_t>(slab.first),
                                           plane * static_cast<std::size_t>(slab.count));
    std::vector<double> phi(mine.size());
    const std::string why = make_multigrid(comm, grid, tolerance)->solve(mine, phi);
    if (fault) *fault = why;
    else EXPECT_EQ(why, "");
    return why.empty() ? comm.all_gather(phi) : std::vector<double>();
}

/// Of f over all cells, root mean squares of their integrals.
double relative_residual(const TensorGrid& grid, const std::vector<double>& phi, const std::vector<double>& f) {
    const std::array<int, 3> n = cells_of(grid);
    double squares = 0, all = 0;
    for_cells(grid, [&](std::size_t cell, int i, int j, int k) {
        double sum = 0;
        for (std::size_t d = 0; d < 3; ++d) {
            const int at[3] = {i, j, k};
            const auto& width = grid.width[d];
            const auto w = [&](int place) { return nth(width, place); };
            for (const int side : {-1, 1}) {
                std::array<int, 3> c{i, j, k};
                c[d] += side;
                if (grid.periodic[d]) c[d] = (c[d] + n[d]) % n[d];
                else if (c[d] < 0 || c[d] >= n[d]) continue;
                const double other = nth(phi, (c[2] * n[1] + c[1]) * n[0] + c[0]);
                sum += (other - phi[cell]) / (0.5 * (w(at[d]) + w(c[d]))) / w(at[d]);
            }
        }
        const double v = volume(grid, i, j, k);
        squares += v * v * (sum - f[cell]) * (sum - f[cell]);
        all += v * v * f[cell] * f[cell];
    });
    return std::sqrt(squares / all);
}

std::vector<double> solved_directly(const Communicator& comm, const FluidGrid& grid, const std::vector<double>& f) {
    const Threads threads(1);
    FastHelmholtz solver(comm, threads, grid, Pencils(grid, comm.rank(), comm.size()));
    const auto [nx, ny, nz] = grid.cells;
    const Slab slab = slab_of(nz, comm.rank(), comm.size());
    std::vector<double> source(f), phi(f.size() + 8);
    source.resize(f.size() + 8);
    const auto place = [&, x = nx, y = ny](int i, int j, int k) {
        return static_cast<std::size_t>(((k + slab.first) * y + j) * x + i);
    };
    solver.solve(
        Helmholtz::of_pressure(grid), [&](int i, int j, int k) { return load<8>(&source[place(i, j, k)]); },
        [&, x = nx](int i, int j, int k, const Pack<8>& p) {
            for (int l = 0; l < std::min(8, x - i); ++l) phi[place(i + l, j, k)] = p[l];
        });
    const std::size_t first = place(0, 0, 0), count = static_cast<std::size_t>(nx * ny * slab.count);
    return comm.all_gather(std::span<const double>(phi).subspan(first, count));
}

double largest(const std::vector<double>& a) {
    double most = 0;
    for (const double x : a) most = std::max(most, std::abs(x));
    return most;
}
double difference(const std::vector<double>& a, const std::vector<double>& b) {
    if (a.size() != b.size()) return HUGE_VAL;
    std::vector<double> less(a);
    for (std::size_t i = 0; i < a.size(); ++i) less[i] -= b[i];
    return largest(less);
}

TEST(Multigrid, EqualsTheDirectSolver) {
    const Communicator comm = Communicator::world();
    for (unsigned walls = 0; walls < 8; ++walls)
        for (const std::array<int, 3> cells : {std::array{24, 20, 18}, std::array{21, 15, 7}, std::array{16, 35, 2},
                                               std::array{2, 9, 40}, std::array{9, 8, 1}}) {
            const FluidGrid grid = grid_of(cells, walls);
            const TensorGrid tensor = even(cells, walls, grid.h);
            const std::vector<double> f = random_numbers(tensor), phi = solved(comm, tensor, f, 1e-12);
            std::vector<double> direct = solved_directly(comm, grid, f);
            centre(tensor, direct);
            ASSERT_EQ(phi.size(), f.size());
            EXPECT_LT(difference(phi, direct), 1e-9 * largest(direct)) << "walls " << walls << " cells " << cells[0];
            EXPECT_LT(relative_residual(tensor, phi, f), 1.1e-12) << "walls " << walls << " cells " << cells[0];
        }
}

/// Conjugate gradients by themselves need hundreds on such grids; and no count of cells is too odd.
TEST(Multigrid, SolvesOnAnyGrid) {
    const Communicator comm = Communicator::world();
    for (unsigned walls = 0; walls < 8; ++walls)
        for (const std::array<int, 3> cells :
             {std::array{31, 17, 13}, std::array{8, 11, 37}, std::array{64, 5, 5}, std::array{3, 3, 4}}) {
            TensorGrid grid = even(cells, walls, 1);
            for (std::size_t d = 0; d < 3; ++d) grid.width[d] = stretched(cells[d], d == 0 ? 1 : 6);
            const std::vector<double> f = random_numbers(grid), phi = solved(comm, grid, f, 1e-11);
            ASSERT_EQ(phi.size(), f.size());
            EXPECT_LT(relative_residual(grid, phi, f), 1.1e-11) << "walls " << walls << " cells " << cells[0];
        }
}

/// cos(2 pi x) cos(pi y) cos(2 pi z), whose gradient across all faces of the unit box is 0.
TEST(Multigrid, ConvergesToAClosedFormOnStretchedGrids) {
    const Communicator comm = Communicator::world();
    for (const unsigned walls : {2U, 7U}) {
        double error[3];
        for (int fine = 0; fine < 3; ++fine) {
            const int n = 16 << fine;
            TensorGrid grid = even({n, n, n}, walls, 1);
            for (std::size_t d = 0; d < 3; ++d) grid.width[d] = stretched(n, d == 1 ? 1 : 4);
            std::array<std::vector<double>, 3> middle;
            for (std::size_t d = 0; d < 3; ++d) {
                double face = 0;
                for (const double w : grid.width[d]) {
                    middle[d].push_back(face + 0.5 * w);
                    face += w;
                }
            }
            std::vector<double> exact;
            for_cells(grid, [&](std::size_t, int i, int j, int k) {
                exact.push_back(std::cos(2 * pi * nth(middle[0], i)) * std::cos(pi * nth(middle[1], j)) *
                                std::cos(2 * pi * nth(middle[2], k)));
            });
            std::vector<double> f(exact);
            for (double& x : f) x *= -9 * pi * pi;
            centre(grid, f);
            std::vector<double> phi = solved(comm, grid, f, 1e-10);
            ASSERT_EQ(phi.size(), exact.size());
            centre(grid, phi);
            centre(grid, exact);
            error[fine] = difference(phi, exact);
        }
        EXPECT_GT(std::log2(error[0] / error[1]), 1.8);
        EXPECT_GT(std::log2(error[1] / error[2]), 1.9);
        EXPECT_LT(error[2], 5e-3);
    }
}

TEST(Multigrid, TellsWhyThereIsNoAnswer) {
    const Communicator comm = Communicator::world();
    const TensorGrid grid = even({16, 16, 16}, 0, 0.1);
    std::vector<double> f = random_numbers(grid);
    std::string fault;
    EXPECT_TRUE(solved(comm, grid, f, 1e-30, &fault).empty());
    EXPECT_NE(fault.find("the residual is "), std::string::npos) << fault;
    f.back() = std::nan(""); // of the last rank
    EXPECT_TRUE(solved(comm, grid, f, 1e-10, &fault).empty());
    EXPECT_NE(fault.find("not finite"), std::string::npos) << fault;
    const std::vector<double> nothing(f.size(), 0.0);
    EXPECT_EQ(solved(comm, grid, nothing, 1e-10), nothing);
}

TEST(Multigrid, StopsAFlowWithoutAPressure) {
    const Threads threads(1);
    FlowConstants constants{
        .grid = grid_of({16, 12, 8}, 0), .pressure = PressureMethod::multigrid, .pressure_tolerance = 1e-30};
    auto flow = make_flow(Communicator::world(), threads, constants);
    EXPECT_THROW(flow->set_velocity([](const Vec3d& at) {
        return Vec3d{std::sin(2 * pi * at.x / 1.6), 0, 0};
    }),
                 NumericalError);
}

/// Vortices of Taylor and Green in three dimensions between walls along z, of any number of cells.
std::unique_ptr<FlowSolver> vortices(const Communicator& comm, const Threads& threads, PressureMethod pressure,
                                     std::array<int, 3> cells, FluidBoundary boundary, FlowScheme scheme) {
    FlowConstants constants{
        .grid = {.cells = cells, .h = 2 * pi / cells[0]}, .kinematic_viscosity = 0.01, .scheme = scheme};
    constants.grid.boundary[2] = boundary;
    constants.pressure = pressure;
    constants.pressure_tolerance = 1e-12;
    auto flow = make_flow(comm, threads, constants);
    flow->set_velocity([](const Vec3d& at) {
        return Vec3d{std::sin(at.x) * std::cos(at.y) * std::cos(at.z),
                     -std::cos(at.x) * std::sin(at.y) * std::cos(at.z), 0};
    });
    for (int s = 0; s < 3; ++s) flow->step(0, 0.05);
    return flow;
}

TEST(Multigrid, StepsTheFluidAsTheDirectSolverDoes) {
    const Communicator comm = Communicator::world();
    const Threads threads(2);
    for (const FlowScheme scheme : {FlowScheme::rk3, FlowScheme::rk3_projected})
        for (const FluidBoundary boundary : {FluidBoundary::periodic, FluidBoundary::no_slip}) {
            const auto flow = [&](PressureMethod pressure) {
                return vortices(comm, threads, pressure, {20, 20, 15}, boundary, scheme);
            };
            const auto direct = flow(PressureMethod::direct), multigrid = flow(PressureMethod::multigrid);
            const FieldLayout layout = direct->layout();
            double speed = 0, apart[4] = {}, higher[2] = {HUGE_VAL, -HUGE_VAL}; // a pressure is free up to a constant
            for (int k = 0; k < layout.nz; ++k)
                for (int j = 0; j < layout.ny; ++j)
                    for (int i = 0; i < layout.nx; ++i) {
                        const auto at = static_cast<std::size_t>(layout.at(i, j, k));
                        for (int c = 0; c < 3; ++c) {
                            apart[c] =
                                std::max(apart[c], std::abs(direct->velocity(c)[at] - multigrid->velocity(c)[at]));
                            speed = std::max(speed, std::abs(direct->velocity(c)[at]));
                        }
                        const double more = direct->pressure()[at] - multigrid->pressure()[at];
                        higher[0] = std::min(higher[0], more);
                        higher[1] = std::max(higher[1], more);
                    }
            speed = comm.max(speed);
            apart[3] = comm.max(higher[1]) - comm.min(higher[0]);
            EXPECT_GT(speed, 0.5);
            for (const double a : apart) EXPECT_LT(a, 1e-9 * speed);
            EXPECT_LT(figures_of(comm, *multigrid).divergence, 1e-9 * speed);
        }
}

TEST(Multigrid, StepsGridsThatTransformsDoNotTake) {
    const Communicator comm = Communicator::world();
    const Threads threads(1);
    const auto flow =
        vortices(comm, threads, PressureMethod::multigrid, {22, 22, 13}, FluidBoundary::no_slip, FlowScheme::rk3);
    EXPECT_LT(figures_of(comm, *flow).divergence, 1e-9);
}

} // namespace
} // namespace skein
