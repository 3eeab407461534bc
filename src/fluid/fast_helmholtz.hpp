// The discrete equations of Poisson and Helmholtz of a box, solved directly: transforms of lines along y and x, plane by plane,
// then a tridiagonal system along z for each of their coefficients.                                           theory.md (77)-(79),
// (84)
#pragma once

#include "fluid/flow.hpp"
#include "fluid/slab_columns.hpp"

#include <optional>
#include <vector>

namespace skein {

/// Planes are transformed whole, so that any ranks have the same bits where columns are solved whole too.
class FastHelmholtz {
public:
    using P = Pack<8>;
    FastHelmholtz(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                  ColumnExchange exchange = ColumnExchange::transposes)
        : threads_(threads), planes_(static_cast<std::size_t>(slab_of(grid.cells[2], comm.rank(), comm.size()).count)),
          transforms_(static_cast<std::size_t>(threads.count()), PlaneTransform(grid)) {
        if (exchange == ColumnExchange::interfaces && comm.size() > 1) slabs_.emplace(comm, threads, grid);
        else whole_.emplace(comm, threads, grid);
    }

    /// source(i, j, k): f in eight cells from (i, j, k) on, of which those beyond the row are left out; sink(i, j, k, phi): takes
    /// phi there, when all of f has been read. k counts planes of this rank. Collective.
    template <class Source, class Sink> void solve(const Helmholtz& equation, Source&& source, Sink&& sink) {
        const CoefficientRows& rows = slabs_ ? slabs_->rows() : whole_->rows();
        threads_.for_each(planes_, [&](std::size_t k, int thread) {
            transforms_[static_cast<std::size_t>(thread)].forward(equation, static_cast<int>(k), rows, source);
        });
        if (slabs_) slabs_->solve(equation);
        else whole_->solve(equation);
        threads_.for_each(planes_, [&](std::size_t k, int thread) {
            transforms_[static_cast<std::size_t>(thread)].back(equation, static_cast<int>(k), rows, sink);
        });
    }

    std::size_t bytes() const { return slabs_ ? slabs_->bytes() : whole_->bytes(); }

private:
    const Threads& threads_;
    std::size_t planes_;
    std::optional<TransposedColumns> whole_; ///< columns: these or the next ones
    std::optional<SlabColumns> slabs_;
    std::vector<PlaneTransform> transforms_; ///< by thread
};

} // namespace skein
