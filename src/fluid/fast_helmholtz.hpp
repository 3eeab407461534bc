// The discrete equations of Poisson and Helmholtz of a box, solved directly: transforms of lines along y and x, plane by plane,
// then a tridiagonal system along z for each of their coefficients.                                           theory.md (77)-(79),
// (84)
#pragma once

#include "fluid/columns.hpp"
#include "fluid/plane_transform.hpp"

#include <vector>

namespace skein {

/// Any ranks, the same bits: planes are transformed whole, and coefficients change ranks for their tridiagonal systems.
class FastHelmholtz {
public:
    using P = Pack<8>;
    FastHelmholtz(const Communicator& comm, const Threads& threads, const FluidGrid& grid)
        : threads_(threads), planes_(static_cast<std::size_t>(slab_of(grid.cells[2], comm.rank(), comm.size()).count)),
          columns_(comm, threads, grid), transforms_(static_cast<std::size_t>(threads.count()), PlaneTransform(grid)) {}

    /// source(i, j, k): f in eight cells from (i, j, k) on, of which those beyond the row are left out; sink(i, j, k, phi): takes
    /// phi there, when all of f has been read. k counts planes of this rank. Collective.
    template <class Source, class Sink> void solve(const Helmholtz& equation, Source&& source, Sink&& sink) {
        threads_.for_each(planes_, [&](std::size_t k, int thread) {
            transforms_[static_cast<std::size_t>(thread)].forward(equation, static_cast<int>(k), columns_.rows(), source);
        });
        columns_.solve(equation);
        threads_.for_each(planes_, [&](std::size_t k, int thread) {
            transforms_[static_cast<std::size_t>(thread)].back(equation, static_cast<int>(k), columns_.rows(), sink);
        });
    }

    std::size_t bytes() const { return columns_.bytes(); }

private:
    const Threads& threads_;
    std::size_t planes_;
    TransposedColumns columns_;
    std::vector<PlaneTransform> transforms_; ///< by thread
};

} // namespace skein
