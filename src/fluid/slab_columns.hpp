// Solver of columns that stay on their ranks: each rank solves its own planes from the numbers just beyond them.
// theory.md (79a), (79b)
#pragma once

#include "fluid/coupled_slabs.hpp"
#include "fluid/neighbours.hpp"
#include "skein/core/index.hpp"

#include <map>

namespace skein {

/// Neighbours exchange one number of each column, which is enough for most coefficients; CoupledSlabs solves the
/// others. There are at least two slabs, on whose number bits depend. Equations are periodic along z if the grid is.
class SlabColumns {
public:
    using P = Columns::P;
    SlabColumns(const Communicator& comm, const Threads& threads, const FluidGrid& grid, const Pencils& pencils)
        : comm_(comm), threads_(threads), grid_(grid), pencils_(pencils), modes_(pencils.modes(pencils.share())),
          planes_(pencils.planes().count), row_(row_of(modes_.count)),
          plane_(static_cast<std::ptrdiff_t>(grid.cells[1]) * row_),
          neighbours_(Neighbours::of_slabs(pencils, grid.periodic(2))),
          work_(to_index(threads.count()), Columns::Work(planes_)) {
        numbers_ = UnsetArray<double>(to_index(planes_ * plane_));
        for (int j = 0; j < grid.cells[1]; ++j)
            rows_.add(numbers_.data() + static_cast<std::ptrdiff_t>(j) * row_, plane_);
        for (AlignedVector<double>* plane : {&first_, &last_, &beyond_lower_, &beyond_upper_})
            plane->assign(to_index(plane_), 0.0);
        NeighbourParts parts(neighbours_);
        parts.add(first_, last_, beyond_lower_, beyond_upper_);
        messages_ = parts.messages(comm);
    }

    /// Rows of modes along y in this rank's planes.
    const PlaneRows& rows() const { return rows_; }
    /// Solves columns in place. Collective.
    void solve(const Helmholtz& equation) {
        const std::array ends{equation.x.ends(), equation.y.ends(), equation.z};
        auto coupled = coupled_.find(ends);
        if (coupled == coupled_.end())
            coupled = coupled_.try_emplace(ends, comm_, threads_, grid_, pencils_, equation).first;
        for_chunks([&](int j, int begin, int end, int) { find_outer(equation, j, begin, end); });
        if (neighbours_.above < 0 && equation.singular() && modes_.first == 0 && modes_.count > 0)
            last_.front() = last_of_constant(equation);
        messages_.start();
        coupled->second.start(equation, first_.data(), last_.data(), row_);
        messages_.finish();
        for_chunks([&](int j, int begin, int end, int) { find_beyond(equation, j, begin, end); });
        coupled->second.finish(beyond_lower_.data(), beyond_upper_.data(), row_);
        for_chunks([&](int j, int begin, int end, int thread) { solve(equation, j, begin, end, nth(work_, thread)); });
    }

    std::size_t bytes() const {
        std::size_t all = (numbers_.size() + 4 * first_.size()) * sizeof(double);
        for (const auto& [ends, coupled] : coupled_) all += coupled.bytes();
        return all;
    }

private:
    /// Calls body(j, begin, end, thread) for coefficients of y mode j, counted from this rank's first x mode.
    template <class Body> void for_chunks(Body&& body) {
        threads_.for_each(to_index(grid_.cells[1]), [&](std::size_t j, int thread) {
            for (int m = 0; m < row_; m += Columns::chunk)
                body(static_cast<int>(j), m, std::min(m + Columns::chunk, row_), thread);
        });
    }
    std::ptrdiff_t place(int j, int m) const { return static_cast<std::ptrdiff_t>(j) * row_ + m; }
    int unknown(const Helmholtz& equation) const { return neighbours_.above < 0 ? equation.unknown(planes_) : planes_; }
    bool at_end() const { return neighbours_.above < 0 || neighbours_.below < 0; }

    /// Finds the first and last number of this slab alone, with 0 beyond interfaces. Each is a sum from the other end
    /// on; a slab at an end of the box needs the one that begins there.
    void find_outer(const Helmholtz& equation, int j, int begin, int end) {
        const int n = unknown(equation);
        const P scale(equation.scale_of_coefficients()), wall(at_end() ? equation.end() : 0.0);
        Columns::for_packs(equation, j, modes_.first, begin, end, [&](int m, const P& diagonal) {
            const double* const f = numbers_.data() + place(j, m);
            P pivot(0.0), from_below(0.0), from_above(0.0);
            for (int k = 0; k < n; ++k) {
                pivot = Columns::inverse_of(diagonal + (k == 0 ? wall : P(0.0)) - pivot);
                from_below = fms(scale, load<8>(f + k * plane_), from_below) * pivot;
                from_above = fms(scale, load<8>(f + (n - 1 - k) * plane_), from_above) * pivot;
            }
            store(&nth(first_, place(j, m)), from_above);
            store(&nth(last_, place(j, m)), from_below);
        });
    }
    /// Last number of the constant mode in the uppermost slab: no gradient at its end, and 0 below it.
    double last_of_constant(const Helmholtz& equation) const {
        double sum = 0;
        for (int k = 0; k < planes_; ++k) sum += (k + 1) * nth(numbers_, k * plane_);
        return -equation.scale_of_coefficients() * sum;
    }
    /// Finds numbers beyond this slab from neighbours, for coefficients that do not reach across a slab.
    void find_beyond(const Helmholtz& equation, int j, int begin, int end) {
        Columns::for_packs(equation, j, modes_.first, begin, end, [&](int m, const P& diagonal) {
            const P cosh = P(-0.5) * diagonal, near = P(1.0) / (cosh + sqrt(max(cosh * cosh - P(1.0), P(0.0)))),
                    inverse = Columns::inverse_of(P(1.0) - near * near);
            const auto join = [&](AlignedVector<double>& beyond, const AlignedVector<double>& own) {
                double* const to = &nth(beyond, place(j, m));
                store(to, fma(near, load<8>(&nth(own, place(j, m))), load<8>(to)) * inverse);
            };
            join(beyond_lower_, first_);
            join(beyond_upper_, last_);
        });
    }
    void solve(const Helmholtz& equation, int j, int begin, int end, Columns::Work& work) {
        const int n = unknown(equation);
        const P scale(equation.scale_of_coefficients()), wall(equation.end());
        Columns::for_packs(equation, j, modes_.first, begin, end, [&](int m, const P& diagonal) {
            Columns::Ends ends;
            if (neighbours_.below < 0) ends.lower = wall;
            else ends.below = load<8>(&nth(beyond_lower_, place(j, m)));
            if (neighbours_.above < 0) ends.upper = wall;
            else ends.above = load<8>(&nth(beyond_upper_, place(j, m)));
            double* const f = numbers_.data() + place(j, m);
            Columns::solve_between(f, plane_, n, scale, diagonal, ends, work);
            if (n < planes_) store(f + n * plane_, P(0.0));
        });
    }

    Communicator comm_;
    const Threads& threads_;
    FluidGrid grid_;
    Pencils pencils_;
    Slab modes_; ///< modes along x of this rank
    int planes_, row_;
    std::ptrdiff_t plane_;
    Neighbours neighbours_;
    UnsetArray<double> numbers_;         ///< [plane][y mode][x mode]
    AlignedVector<double> first_, last_; ///< [y mode][x mode]: outer numbers of this slab alone
    /// [y mode][x mode]: outer numbers of neighbours, later the numbers beyond this slab.
    AlignedVector<double> beyond_lower_, beyond_upper_;
    PlaneRows rows_;
    RepeatedMessages messages_;
    std::map<std::array<LineEnds, 3>, CoupledSlabs> coupled_; ///< by the ends of lines of an equation
    std::vector<Columns::Work> work_;                         ///< by thread
};

} // namespace skein
