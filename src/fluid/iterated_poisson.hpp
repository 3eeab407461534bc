// PressureSolver with the sources and sinks of FastHelmholtz, eight cells at a time.
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/lanes.hpp"
#include "fluid/pressure_solver.hpp"
#include "parallel/threads.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

namespace skein {

class IteratedPoisson {
public:
    IteratedPoisson(const Communicator& comm, const Threads& threads, const FluidGrid& grid, double tolerance)
        : threads_(threads), nx_(grid.cells[0]), ny_(grid.cells[1]),
          planes_(slab_of(grid.cells[2], comm.rank(), comm.size()).count),
          solver_(make_multigrid(comm, tensor_grid(grid), tolerance)) {
        const auto cells = to_index(nx_) * to_index(ny_) * to_index(planes_);
        source_.assign(cells, 0.0);
        answer_.assign(cells + 8, 0.0); // packs reach beyond the last row
    }

    /// Solves like FastHelmholtz::solve(). Throws NumericalError on all ranks without a solution. Collective.
    template <class Source, class Sink> void solve(Source&& source, Sink&& sink) {
        for_packs([&](int i, int j, int k, std::size_t at) {
            double lanes[8];
            store(lanes, source(i, j, k));
            std::copy_n(lanes, std::min(8, nx_ - i), &source_[at]);
        });
        if (const std::string fault = solver_->solve(source_, std::span(answer_).first(source_.size())); !fault.empty())
            throw NumericalError(fault);
        for_packs([&](int i, int j, int k, std::size_t at) { sink(i, j, k, load<8>(&answer_[at])); });
    }

    std::size_t bytes() const { return solver_->bytes() + (source_.size() + answer_.size()) * sizeof(double); }

private:
    static TensorGrid tensor_grid(const FluidGrid& grid) {
        TensorGrid tensor;
        for (std::size_t d = 0; d < 3; ++d) {
            tensor.width[d].assign(to_index(grid.cells[d]), grid.h);
            tensor.periodic[d] = grid.periodic(static_cast<int>(d));
        }
        return tensor;
    }
    template <class Body> void for_packs(Body&& body) const {
        threads_.for_each(to_index(planes_), [&](std::size_t k, int) {
            for (int j = 0; j < ny_; ++j)
                for (int i = 0; i < nx_; i += 8)
                    body(i, j, static_cast<int>(k), (k * to_index(ny_) + to_index(j)) * to_index(nx_) + to_index(i));
        });
    }

    const Threads& threads_;
    int nx_, ny_, planes_;
    std::unique_ptr<PressureSolver> solver_;
    std::vector<double> source_, answer_; ///< [plane][y][x]
};

} // namespace skein
