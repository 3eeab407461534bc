// Direct solver of the discrete equations of Poisson and Helmholtz in a box. It transforms lines along x and y, and
// solves a tridiagonal system along z for each coefficient. theory.md (77)-(79), (84)
#pragma once

#include "fluid/flow.hpp"
#include "fluid/row_exchange.hpp"
#include "fluid/slab_columns.hpp"
#include "skein/core/index.hpp"

#include <optional>
#include <vector>

namespace skein {

/// Lines are transformed whole. If columns are solved whole too, any number of ranks gives the same bits.
class FastHelmholtz {
public:
    using P = Pack<8>;
    FastHelmholtz(const Communicator& comm, const Threads& threads, const FluidGrid& grid, const Pencils& pencils,
                  ColumnExchange exchange = ColumnExchange::transposes)
        : threads_(threads), planes_(pencils.planes().count) {
        if (exchange == ColumnExchange::interfaces && pencils.slabs() > 1) slabs_.emplace(comm, threads, grid, pencils);
        else whole_.emplace(comm, threads, grid, pencils);
        if (pencils.across() > 1) shared_.emplace(comm, grid, pencils);
        for (int t = 0; t < threads.count(); ++t)
            work_.push_back({TransformAlongX(grid.cells[0], pencils.rows().count),
                             TransformAlongY(pencils.modes(pencils.share()).count)});
    }

    /// Function source(i, j, k) returns f in eight cells from (i, j, k) on, and cells beyond the row are ignored.
    /// Function sink(i, j, k, phi) takes phi there, after all of f has been read. Rows j and planes k are those of this
    /// rank. Collective.
    template <class Source, class Sink> void solve(const Helmholtz& equation, Source&& source, Sink&& sink) {
        const PlaneRows& columns = slabs_ ? slabs_->rows() : whole_->rows();
        if (shared_) {
            for_planes([&](Work& work, int k) { work.x.forward(equation.x, k, shared_->of_rows(), source); });
            shared_->to_modes();
        }
        const auto forward = [&](Work& work, int k) {
            if (shared_) return work.y.forward(equation.y, k, shared_->of_modes(), columns);
            work.x.forward(equation.x, k, source); // the plane stays in the cache
            work.y.forward(equation.y, k, work.x.tiles(equation.x), columns);
        };
        const auto back = [&](Work& work, int k) {
            if (shared_) return work.y.back(equation.y, k, columns, shared_->of_modes());
            work.y.back(equation.y, k, columns, work.x.tiles(equation.x));
            work.x.back(equation.x, k, sink);
        };
        if (slabs_) {
            for_planes(forward);
            slabs_->solve(equation);
            for_planes(back);
        } else {
            whole_->send(planes_, [&](int first, int end) { for_planes(first, end, forward); });
            whole_->solve(equation);
            whole_->receive(planes_, [&](int first, int end) { for_planes(first, end, back); });
        }
        if (shared_) {
            shared_->to_rows();
            for_planes([&](Work& work, int k) { work.x.back(equation.x, k, shared_->of_rows(), sink); });
        }
    }

    std::size_t bytes() const {
        return (slabs_ ? slabs_->bytes() : whole_->bytes()) + (shared_ ? shared_->bytes() : 0);
    }

private:
    struct Work {
        TransformAlongX x;
        TransformAlongY y;
    };
    template <class Body> void for_planes(int first, int end, Body&& body) {
        threads_.for_each(to_index(end - first),
                          [&](std::size_t k, int thread) { body(nth(work_, thread), first + static_cast<int>(k)); });
    }
    template <class Body> void for_planes(Body&& body) { for_planes(0, planes_, body); }

    const Threads& threads_;
    int planes_;
    std::optional<TransposedColumns> whole_; ///< solver of whole columns
    std::optional<SlabColumns> slabs_;       ///< solver of columns in slabs, in place of whole_
    std::optional<RowExchange> shared_;      ///< absent if this rank has all rows of its planes
    std::vector<Work> work_;                 ///< by thread
};

} // namespace skein
