// The fluid on one core, ns per cell: Poisson's equation beside a pair of FFTW's transforms of the same size and
// multigrid, and whole steps beside what memory alone would take.
//
//   bench_fluid [options of Google Benchmark]
#include "fluid/fast_helmholtz.hpp"
#include "fluid/iterated_poisson.hpp"
#include "fluid/make_flow.hpp"
#include "immersion/immersion.hpp"
#include "skein/core/index.hpp"

#include <benchmark/benchmark.h>

#include <fftw3.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

namespace skein {
namespace {

FluidGrid cube(int n, FluidBoundary boundary) {
    return {.cells = {n, n, n}, .h = 2 * std::numbers::pi / n, .boundary = {boundary, boundary, boundary}};
}

void per_cell(benchmark::State& state, double cells) {
    state.counters["ns/cell"] =
        benchmark::Counter(cells * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void poisson(benchmark::State& state, int n, FluidBoundary boundary) {
    const FluidGrid grid = cube(n, boundary);
    const Communicator comm = Communicator::alone();
    const Threads threads(1);
    FastHelmholtz solver(comm, threads, grid, Pencils(grid, 0, 1));
    const Helmholtz equation = Helmholtz::of_pressure(grid);
    const FieldLayout layout(n, n, n);
    AlignedVector<double> field(layout.size(), 1.0);
    for (auto _ : state)
        solver.solve(
            equation, [&](int i, int j, int k) { return load<8>(&nth(field, layout.at(i, j, k))); },
            [&](int i, int j, int k, const Pack<8>& p) { store(&nth(field, layout.at(i, j, k)), p); });
    per_cell(state, static_cast<double>(grid.count()));
}

/// The same by iterations, of a right side that varies from cell to cell.
void multigrid(benchmark::State& state, int n, FluidBoundary boundary, double tolerance) {
    const FluidGrid grid = cube(n, boundary);
    const Threads threads(1);
    IteratedPoisson solver(Communicator::alone(), threads, grid, tolerance);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    const FieldLayout layout(n, n, n);
    AlignedVector<double> field(layout.size(), 0.0), phi(layout.size(), 0.0);
    for (double& f : field) f = normal(random);
    for (auto _ : state)
        solver.solve([&](int i, int j, int k) { return load<8>(&nth(field, layout.at(i, j, k))); },
                     [&](int i, int j, int k, const Pack<8>& p) { store(&nth(phi, layout.at(i, j, k)), p); });
    per_cell(state, static_cast<double>(grid.count()));
    state.counters["bytes/cell"] = static_cast<double>(solver.bytes()) / static_cast<double>(grid.count());
}

/// There and back, in place, without a division.
void fftw_pair(benchmark::State& state, int n) {
    const std::size_t rows = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
    AlignedVector<double> field(rows * 2 * static_cast<std::size_t>(n / 2 + 1), 0.0);
    auto* spectrum = reinterpret_cast<fftw_complex*>(field.data());
    fftw_plan there = fftw_plan_dft_r2c_3d(n, n, n, field.data(), spectrum, FFTW_MEASURE),
              back = fftw_plan_dft_c2r_3d(n, n, n, spectrum, field.data(), FFTW_MEASURE);
    for (auto _ : state) {
        fftw_execute(there);
        fftw_execute(back);
    }
    per_cell(state, static_cast<double>(rows) * n);
    fftw_destroy_plan(there);
    fftw_destroy_plan(back);
}

/// Of `sweeps`, with a sphere a quarter of the cube across; of none without it.
void step(benchmark::State& state, int n, FluidBoundary boundary, FlowScheme scheme, int sweeps = 0) {
    const FlowConstants constants{.grid = cube(n, boundary), .kinematic_viscosity = 0.01, .scheme = scheme};
    const Threads threads(1);
    auto flow = make_flow(Communicator::alone(), threads, constants);
    flow->set_velocity([](const Vec3d& at) {
        return Vec3d{std::sin(at.x) * std::cos(at.y) * std::cos(at.z),
                     -std::cos(at.x) * std::sin(at.y) * std::cos(at.z), 0};
    });
    const double middle = std::numbers::pi;
    Immersion bodies(Communicator::alone(), threads, constants.grid, {.sweeps = sweeps},
                     {Obstacle{.centre = {middle, middle, middle}, .radius = middle / 4}});
    if (sweeps > 0) flow->set_forcing(&bodies.forcing());
    for (auto _ : state) flow->step(0, 1e-3);
    const double cells = static_cast<double>(constants.grid.count());
    per_cell(state, cells);
    state.counters["bytes/cell"] = static_cast<double>(flow->bytes()) / cells;
}

/// y = a y + x of arrays that no cache holds: bytes per second.
void streaming(benchmark::State& state) {
    AlignedVector<double> x(1 << 24, 1.0), y(1 << 24, 2.0);
    for (auto _ : state) {
        for (std::size_t i = 0; i < x.size(); i += 8) store(&y[i], fma(Pack<8>(0.5), load<8>(&y[i]), load<8>(&x[i])));
        benchmark::ClobberMemory();
    }
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(3 * 8 * x.size()));
}

} // namespace
} // namespace skein

int main(int argc, char** argv) {
    using namespace skein;
    const MpiSession mpi(argc, argv);
    for (const int n : {64, 128, 256}) {
        const std::string size = "/" + std::to_string(n);
        const auto add = [](const std::string& name, auto&& body) {
            benchmark::RegisterBenchmark(name.c_str(), body)->Unit(benchmark::kMillisecond);
        };
        add("fftw r2c and c2r" + size, [n](benchmark::State& s) { fftw_pair(s, n); });
        for (const FluidBoundary boundary : {FluidBoundary::free_slip, FluidBoundary::periodic}) {
            const std::string box = boundary == FluidBoundary::periodic ? " periodic" : " box";
            add("poisson" + box + size, [=](benchmark::State& s) { poisson(s, n, boundary); });
#ifdef SKEIN_PETSC
            if (n <= 128)
                for (const double tolerance : {1e-6, 1e-10})
                    add("multigrid to " + std::string(tolerance < 1e-8 ? "1e-10" : "1e-6") + box + size,
                        [=](benchmark::State& s) { multigrid(s, n, boundary, tolerance); });
#endif
            for (const FlowScheme scheme :
                 {FlowScheme::rk3, FlowScheme::rk3_projected, FlowScheme::adams_bashforth, FlowScheme::crank_nicolson})
                add("step " + std::string(nth(flow_scheme_names, scheme)) + box + size,
                    [=](benchmark::State& s) { step(s, n, boundary, scheme); });
            for (const FlowScheme scheme : {FlowScheme::rk3, FlowScheme::crank_nicolson})
                for (const int sweeps : {1, 2})
                    add("step " + std::string(nth(flow_scheme_names, scheme)) + ", sphere, sweeps " +
                            std::to_string(sweeps) + box + size,
                        [=](benchmark::State& s) { step(s, n, boundary, scheme, sweeps); });
        }
    }
    benchmark::RegisterBenchmark("streaming", streaming)->Unit(benchmark::kMillisecond);
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
}
