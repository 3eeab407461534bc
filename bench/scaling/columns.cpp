// What the two ways cost in which ranks share the columns of the direct solver, solves and whole steps, in turn on the
// ranks that it is started on; and what a rank sends.
//   mpirun -n 2 build/bin/columns --cells 128 256
#include "core/timer.hpp"
#include "fluid/fast_helmholtz.hpp"
#include "fluid/make_flow.hpp"
#include "skein/core/index.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <numbers>
#include <string>
#include <vector>

namespace skein {
namespace {

constexpr std::array exchanges{ColumnExchange::transposes, ColumnExchange::interfaces};

/// Seconds of one call on the slowest rank, by round, and bytes that the rank which sends most has sent.
struct Times {
    std::vector<double> seconds;
    double bytes = 0;

    template <class Body> void take(const Communicator& comm, int calls, Body&& body) {
        comm.barrier();
        const std::int64_t before = Communicator::traffic().bytes;
        const double began = wall_seconds();
        for (int c = 0; c < calls; ++c) body();
        seconds.push_back(comm.max(wall_seconds() - began) / calls);
        bytes = comm.max(static_cast<double>(Communicator::traffic().bytes - before) / calls);
    }
    double least() const { return *std::min_element(seconds.begin(), seconds.end()); }
    double median() const {
        std::vector<double> sorted = seconds;
        std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
        return sorted[sorted.size() / 2];
    }
};

void show(const Communicator& comm, const std::string& what, ColumnExchange exchange, const Times& times,
          double cells) {
    if (!comm.root()) return;
    fmt::print("{:<26}{:<12}{:>12.2f}{:>12.2f}{:>12.2f}{:>12.3f}\n", what, nth(column_exchange_names, exchange),
               1e3 * times.least(), 1e3 * times.median(), 1e9 * times.least() / cells, 1e-6 * times.bytes);
}

void measure(const Communicator& comm, const Threads& threads, int n, FluidBoundary boundary, int rounds, int calls) {
    const FluidGrid grid{.cells = {n, n, n}, .h = 2 * std::numbers::pi / n, .boundary = {boundary, boundary, boundary}};
    const double cells = static_cast<double>(grid.count());
    const std::string box = fmt::format("{}^3 {}", n, boundary == FluidBoundary::periodic ? "periodic" : "box");
    Times solves[2], steps[2];
    {
        const Helmholtz equation = Helmholtz::of_pressure(grid);
        const Pencils pencils(grid, comm.rank(), comm.size());
        const FieldLayout layout = pencils.layout();
        AlignedVector<double> field(layout.size(), 1.0);
        const auto at = [&](int i, int j, int k) { return &nth(field, layout.at(i, j, k)); };
        std::vector<FastHelmholtz> solvers;
        solvers.reserve(2);
        for (const ColumnExchange exchange : exchanges) solvers.emplace_back(comm, threads, grid, pencils, exchange);
        const auto solve = [&](FastHelmholtz& solver) {
            solver.solve(
                equation, [&](int i, int j, int k) { return load<8>(at(i, j, k)); },
                [&](int i, int j, int k, const Pack<8>& phi) { store(at(i, j, k), phi); });
        };
        for (FastHelmholtz& solver : solvers) solve(solver);
        for (int round = 0; round < rounds; ++round)
            for (std::size_t e = 0; e < 2; ++e) solves[e].take(comm, calls, [&] { solve(solvers[e]); });
    }
    for (std::size_t e = 0; e < 2; ++e) show(comm, box + ", solve", exchanges[e], solves[e], cells);
    std::unique_ptr<FlowSolver> flows[2];
    for (std::size_t e = 0; e < 2; ++e) {
        flows[e] = make_flow(comm, threads, {.grid = grid, .kinematic_viscosity = 0.01, .exchange = exchanges[e]});
        flows[e]->set_velocity([](const Vec3d& at) {
            return Vec3d{std::sin(at.x) * std::cos(at.y) * std::cos(at.z),
                         -std::cos(at.x) * std::sin(at.y) * std::cos(at.z), 0};
        });
    }
    for (int round = 0; round < rounds; ++round)
        for (std::size_t e = 0; e < 2; ++e) steps[e].take(comm, calls, [&] { flows[e]->step(0, 1e-4); });
    for (std::size_t e = 0; e < 2; ++e) show(comm, box + ", step of rk3", exchanges[e], steps[e], cells);
}

} // namespace
} // namespace skein

int main(int argc, char** argv) try {
    CLI::App app("Times of the direct solver and of steps by both ways of exchange between ranks.");
    std::vector<int> cells{128};
    int rounds = 9, calls = 5, threads = 1;
    app.add_option("--cells", cells, "along an edge")->check(CLI::PositiveNumber);
    app.add_option("--rounds", rounds, "through both, in turn")->check(CLI::PositiveNumber);
    app.add_option("--calls", calls, "of each in a round")->check(CLI::PositiveNumber);
    app.add_option("--threads", threads, "per rank")->check(CLI::PositiveNumber);
    CLI11_PARSE(app, argc, argv);

    using namespace skein;
    const MpiSession mpi(argc, argv);
    const Communicator comm = Communicator::world();
    const Threads team(threads);
    if (comm.root())
        fmt::print("{} ranks of {} threads\n{:<26}{:<12}{:>12}{:>12}{:>12}{:>12}\n", comm.size(), threads, "", "",
                   "least ms", "median ms", "ns per cell", "MB sent");
    for (const int n : cells)
        for (const FluidBoundary boundary : {FluidBoundary::free_slip, FluidBoundary::periodic})
            measure(comm, team, n, boundary, rounds, calls);
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 2;
}
