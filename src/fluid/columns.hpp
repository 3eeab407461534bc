// Tridiagonal systems along z for coefficients along x and y. theory.md (78)
#pragma once

#include "fluid/helmholtz.hpp"
#include "fluid/lanes.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/pencils.hpp"
#include "fluid/plane_transform.hpp"
#include "parallel/communicator.hpp"
#include "parallel/messages.hpp"
#include "parallel/threads.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <vector>

namespace skein {

/// Eight columns side by side.
class Columns {
public:
    using P = Pack<8>;
    /// Columns that a thread solves one after the other, so that it reads planes in whole cache lines.
    static constexpr int chunk = 32;

    /// Inverse of a pivot, or 0 for a pivot within rounding of 0: the constant, which is free.
    SKEIN_INLINE static P inverse_of(P pivot) {
        const Mask<8> some = abs(pivot) > P(1e-11);
        return select(some, P(1.0) / select(some, pivot, P(1.0)), P(0.0));
    }

    /// Memory of a thread: adjacent rows of eight numbers, which stay in its nearest cache. Rows of the columns are
    /// whole planes apart.
    struct Work {
        explicit Work(int nz) {
            for (AlignedVector<double>* rows : {&pivots, &values, &lasts}) rows->resize(to_index(8 * nz));
        }
        AlignedVector<double> pivots, values;
        AlignedVector<double> lasts; ///< responses to the last unknown of a period
    };
    /// Conditions at both ends of n numbers: additions to the diagonal, and the numbers beyond.
    struct Ends {
        P lower{0.0}, upper{0.0}, below{0.0}, above{0.0};
    };

    /// Solves for n numbers that are `plane` apart, from right sides over `scale`.
    static void solve_between(double* f, std::ptrdiff_t plane, int n, P scale, P diagonal, const Ends& ends,
                              Work& work) {
        if (n == 0) return;
        double *const pivots = work.pivots.data(), *const values = work.values.data();
        P pivot(0.0), value = ends.below;
        for (int k = 0; k < n; ++k) {
            const P more = (k == 0 ? ends.lower : P(0.0)) + (k == n - 1 ? ends.upper : P(0.0));
            pivot = inverse_of(diagonal + more - pivot);
            value = fms(scale, next(f + k * plane), k == n - 1 ? value + ends.above : value) * pivot;
            store(pivots + 8 * k, pivot);
            store(values + 8 * k, value);
        }
        store(f + (n - 1) * plane, value);
        for (int k = n - 2; k >= 0; --k) {
            value = fnma(load<8>(pivots + 8 * k), value, load<8>(values + 8 * k));
            store(f + k * plane, value);
        }
    }
    /// Solves a period: all unknowns by the last one, x_k = y_k + z_k x_last, then the last one.
    static void solve_period(double* f, std::ptrdiff_t plane, int nz, P scale, P diagonal, Work& work) {
        if (nz == 1) {
            store(f, scale * load<8>(f) * inverse_of(diagonal + P(2.0)));
            return;
        }
        if (nz == 2) { // both neighbours are one cell
            const P a = scale * load<8>(f), b = scale * load<8>(f + plane),
                    sum = (a + b) * inverse_of(diagonal + P(2.0)), difference = (a - b) * inverse_of(diagonal - P(2.0));
            store(f, P(0.5) * (sum + difference));
            store(f + plane, P(0.5) * (sum - difference));
            return;
        }
        const int n = nz - 1;
        double *const pivots = work.pivots.data(), *const values = work.values.data(), *const lasts = work.lasts.data();
        P pivot(0.0), y(0.0), z(0.0);
        for (int k = 0; k < n; ++k) {
            pivot = inverse_of(diagonal - pivot);
            y = fms(scale, next(f + k * plane), y) * pivot;
            z = ((k == 0 ? P(-1.0) : P(0.0)) + (k == n - 1 ? P(-1.0) : P(0.0)) - z) * pivot;
            store(pivots + 8 * k, pivot);
            store(values + 8 * k, y);
            store(lasts + 8 * k, z);
        }
        const P y_end = y, z_end = z;
        for (int k = n - 2; k >= 0; --k) {
            const P p = load<8>(pivots + 8 * k);
            y = fnma(p, y, load<8>(values + 8 * k));
            z = fnma(p, z, load<8>(lasts + 8 * k));
            store(values + 8 * k, y);
            store(lasts + 8 * k, z);
        }
        const P x = (scale * next(f + n * plane) - y_end - y) * inverse_of(diagonal + z_end + z);
        for (int k = 0; k < n; ++k) store(f + k * plane, fma(load<8>(lasts + 8 * k), x, load<8>(values + 8 * k)));
        store(f + n * plane, x);
    }

    /// Calls body(at, diagonal) for eight coefficients of y mode j, from x mode first + at on.
    template <class Body>
    static void for_packs(const Helmholtz& equation, int j, int first, int begin, int end, Body&& body) {
        for (int at = begin; at < end; at += 8) {
            P diagonal(0.0);
            for (int l = 0; l < 8; ++l) diagonal.set(l, equation.diagonal(first + at + l, j));
            body(at, diagonal);
        }
    }

private:
    /// Loads eight numbers and prefetches those of the next chunk.
    SKEIN_INLINE static P next(const double* numbers) {
        __builtin_prefetch(numbers + chunk, 1, 2);
        return load<8>(numbers);
    }
};

/// Solver of whole columns, which change ranks for it. Ranks with the same share of modes along x solve different modes
/// along y. Any number of ranks gives the same bits.
class TransposedColumns {
public:
    using P = Columns::P;
    TransposedColumns(const Communicator& comm, const Threads& threads, const FluidGrid& grid, const Pencils& pencils)
        : threads_(threads), nz_(grid.cells[2]), first_mode_(pencils.modes(pencils.share()).first),
          row_(row_of(pencils.modes(pencils.share()).count)),
          own_(slab_of(grid.cells[1], pencils.slab(), pencils.slabs())),
          work_(to_index(threads.count()), Columns::Work(nz_)) {
        column_ = UnsetArray<double>(numbers(nz_, own_.count));
        if (pencils.slabs() == 1) {
            for (int j = 0; j < own_.count; ++j) add_row(column_.data(), j, own_.count);
            return;
        }
        const int planes = pencils.planes().count, chunks = chunks_of(comm, grid, pencils);
        spectrum_ = UnsetArray<double>(numbers(planes, grid.cells[1]));
        std::vector<std::vector<RepeatedMessages::Part>> of_planes(to_index(chunks)), of_modes = of_planes;
        for (int s = 0; s < pencils.slabs(); ++s) {
            const int rank = pencils.rank_of(s, pencils.share());
            const Slab other = pencils.planes(s), modes = slab_of(grid.cells[1], s, pencils.slabs());
            double* const to = spectrum_.data() + numbers(planes, modes.first);
            double* const from = column_.data() + numbers(other.first, own_.count);
            const auto part = [&](double* all, const Slab& of, int row_count) {
                return message_part(rank, {all + numbers(of.first, row_count), numbers(of.count, row_count)});
            };
            for (int c = 0; c < chunks; ++c) {
                nth(of_planes, c).push_back(part(to, slab_of(planes, c, chunks), modes.count));
                nth(of_modes, c).push_back(part(from, slab_of(other.count, c, chunks), own_.count));
            }
            for (int j = 0; j < modes.count; ++j) add_row(to, j, modes.count);
        }
        for (int c = 0; c < chunks; ++c) {
            const auto &sent = nth(of_planes, c), &come = nth(of_modes, c);
            chunks_.push_back(
                {slab_of(planes, c, chunks), RepeatedMessages(comm, sent, come), RepeatedMessages(comm, come, sent)});
        }
    }

    /// Rows of modes along y in this rank's planes.
    const PlaneRows& rows() const { return rows_; }
    /// Calls body(first, end) for chunks of this rank's planes to compute right sides, and sends each chunk meanwhile.
    /// Collective.
    template <class Body> void send(int planes, Body&& body) {
        if (chunks_.empty()) return body(0, planes);
        for (Chunk& chunk : chunks_) {
            body(chunk.planes.first, chunk.planes.first + chunk.planes.count);
            chunk.to_columns.start();
        }
        for (Chunk& chunk : chunks_) chunk.to_columns.finish();
    }
    /// Solves the columns of this rank in place.
    void solve(const Helmholtz& equation) {
        threads_.for_each(to_index(own_.count),
                          [&](std::size_t j, int thread) { solve(equation, static_cast<int>(j), nth(work_, thread)); });
    }
    /// Calls body(first, end) for chunks of this rank's planes with their solution, while later chunks arrive.
    /// Collective.
    template <class Body> void receive(int planes, Body&& body) {
        if (chunks_.empty()) return body(0, planes);
        for (Chunk& chunk : chunks_) chunk.to_planes.start();
        for (Chunk& chunk : chunks_) {
            chunk.to_planes.finish();
            body(chunk.planes.first, chunk.planes.first + chunk.planes.count);
        }
    }

    std::size_t bytes() const { return (column_.size() + spectrum_.size()) * sizeof(double); }

private:
    /// Planes that are sent together.
    struct Chunk {
        Slab planes;
        RepeatedMessages to_columns, to_planes;
    };
    /// Number of chunks, at most four, with at least one plane for each thread. All ranks have the same.
    int chunks_of(const Communicator& comm, const FluidGrid& grid, const Pencils& pencils) const {
        const std::int64_t threads = comm.max(static_cast<std::int64_t>(threads_.count()));
        return static_cast<int>(std::clamp<std::int64_t>(grid.cells[2] / pencils.slabs() / threads, 1, most_chunks));
    }
    static constexpr int most_chunks = 4;

    std::size_t numbers(int planes, int modes) const { return to_index(planes) * to_index(modes) * to_index(row_); }
    /// Adds the row of a mode to rows_; planes have `modes` rows.
    void add_row(double* planes, int mode, int modes) {
        rows_.add(planes + static_cast<std::ptrdiff_t>(mode) * row_, static_cast<std::ptrdiff_t>(modes) * row_);
    }
    void solve(const Helmholtz& equation, int j, Columns::Work& work) {
        const int unknown = equation.unknown(nz_);
        const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(own_.count) * row_;
        const P scale(equation.scale_of_coefficients()), end(equation.end());
        for (int begin = 0; begin < row_; begin += Columns::chunk)
            Columns::for_packs(equation, own_.first + j, first_mode_, begin, std::min(begin + Columns::chunk, row_),
                               [&](int at, const P& diagonal) {
                                   double* const f = column_.data() + static_cast<std::ptrdiff_t>(j) * row_ + at;
                                   if (equation.z == LineEnds::periodic)
                                       Columns::solve_period(f, plane, nz_, scale, diagonal, work);
                                   else
                                       Columns::solve_between(f, plane, unknown, scale, diagonal,
                                                              {.lower = end, .upper = end}, work);
                                   if (unknown < nz_) store(f + unknown * plane, P(0.0));
                               });
    }

    const Threads& threads_;
    int nz_, first_mode_, row_;   ///< first mode along x; length of rows for this rank's modes
    Slab own_;                    ///< modes along y of the columns that this rank solves
    UnsetArray<double> column_;   ///< [z][y mode][x mode]
    UnsetArray<double> spectrum_; ///< [slab][plane][y mode][x mode] to be sent; empty with one slab
    PlaneRows rows_;
    std::vector<Chunk> chunks_;       ///< empty with one slab
    std::vector<Columns::Work> work_; ///< by thread
};

} // namespace skein
