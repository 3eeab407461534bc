// The discrete equations of Poisson and Helmholtz of a box, solved directly: transforms of lines along y and x, plane by plane,
// then a tridiagonal system along z for each of their coefficients.                                           theory.md (77)-(79),
// (84)
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/line_transform.hpp"
#include "parallel/communicator.hpp"
#include "parallel/messages.hpp"
#include "parallel/threads.hpp"
#include "skein/core/aligned.hpp"

#include <algorithm>
#include <vector>

namespace skein {

/// (sum over directions of second differences + shift) phi = scale f, by what phi does at the ends of lines of each direction.
struct Helmholtz {
    Helmholtz(const FluidGrid& grid, const std::array<LineEnds, 3>& ends)
        : x(grid.cells[0], ends[0]), y(grid.cells[1], ends[1]), z(ends[2]) {}
    /// Of a pressure: no gradient across faces that are no period.
    static Helmholtz of_pressure(const FluidGrid& grid) {
        const auto end = [&](int d) { return grid.periodic(d) ? LineEnds::periodic : LineEnds::gradient_zero; };
        Helmholtz equation(grid, {end(0), end(1), end(2)});
        equation.scale = grid.h * grid.h;
        return equation;
    }
    LineTransform x, y;
    LineEnds z;
    double shift = 0, scale = 1;
};

/// Any ranks, the same bits: planes are transformed whole, and coefficients change ranks for their tridiagonal systems.
class FastHelmholtz {
public:
    using P = Pack<8>;
    FastHelmholtz(const Communicator& comm, const Threads& threads, const FluidGrid& grid)
        : threads_(threads), grid_(grid), ranks_(comm.size()), slab_(slab_of(grid.cells[2], comm.rank(), comm.size())),
          modes_(slab_of(grid.cells[0], comm.rank(), comm.size())), row_((grid.cells[1] + 15) / 16 * 16),
          work_(static_cast<std::size_t>(threads.count())) {
        const std::size_t planes = static_cast<std::size_t>(grid.cells[2]);
        column_ = UnsetArray<double>(planes * static_cast<std::size_t>(modes_.count) * static_cast<std::size_t>(row_));
        if (comm.size() > 1) {
            spectrum_ = UnsetArray<double>(static_cast<std::size_t>(slab_.count) * static_cast<std::size_t>(grid.cells[0] * row_));
            std::vector<RepeatedMessages::Part> of_planes, of_modes;
            for (int r = 0; r < comm.size(); ++r) {
                const Slab other = slab_of(grid.cells[2], r, comm.size());
                const auto count = [&](int planes, int modes) {
                    return static_cast<std::size_t>(planes) * static_cast<std::size_t>(modes) * static_cast<std::size_t>(row_);
                };
                double* const from = column_.data() + count(other.first, modes_.count);
                of_planes.push_back({r, std::as_writable_bytes(std::span(spectrum_of(r), count(slab_.count, modes_of(r).count)))});
                of_modes.push_back({r, std::as_writable_bytes(std::span(from, count(other.count, modes_.count)))});
            }
            to_columns_ = RepeatedMessages(comm, of_planes, of_modes);
            to_planes_ = RepeatedMessages(comm, of_modes, of_planes);
        }
        const std::size_t wide = static_cast<std::size_t>((grid.cells[0] + 15) / 16 * 16);
        for (Work& w : work_) {
            w.plane.assign(static_cast<std::size_t>(row_) * wide, 0.0);
            w.pivot.resize(planes * chunk);
            w.last.resize(planes * chunk);
        }
        wide_ = static_cast<std::ptrdiff_t>(wide);
    }

    /// source(i, j, k): f in eight cells from (i, j, k) on, of which those beyond the row are left out; sink(i, j, k, phi): takes
    /// phi there, when all of f has been read. k counts planes of this rank. Collective.
    template <class Source, class Sink> void solve(const Helmholtz& equation, Source&& source, Sink&& sink) {
        for (Work& w : work_) {
            w.in.resize(std::max({w.in.size(), equation.x.block(), equation.y.block()}));
            w.out.resize(w.in.size());
        }
        threads_.for_each(static_cast<std::size_t>(slab_.count), [&](std::size_t k, int thread) {
            transform_plane(equation, static_cast<int>(k), work_[static_cast<std::size_t>(thread)], source);
        });
        if (distributed()) to_columns_.start(), to_columns_.finish();
        threads_.for_each(static_cast<std::size_t>(modes_.count), [&](std::size_t m, int thread) {
            solve_columns(equation, static_cast<int>(m), work_[static_cast<std::size_t>(thread)]);
        });
        if (distributed()) to_planes_.start(), to_planes_.finish();
        threads_.for_each(static_cast<std::size_t>(slab_.count), [&](std::size_t k, int thread) {
            transform_plane_back(equation, static_cast<int>(k), work_[static_cast<std::size_t>(thread)], sink);
        });
    }

    std::size_t bytes() const { return (column_.size() + spectrum_.size()) * sizeof(double); }

private:
    static constexpr int chunk = 32; ///< columns that are solved side by side
    struct Work {
        AlignedVector<double> plane;   ///< [y][x]
        AlignedVector<double> in, out; ///< of a transform
        AlignedVector<double> pivot;   ///< [z][chunk]
        AlignedVector<double> last;    ///< [z][chunk]: answers to the last unknown of a period
    };

    bool distributed() const { return ranks_ > 1; }
    Slab modes_of(int rank) const { return slab_of(grid_.cells[0], rank, ranks_); }
    double* spectrum_of(int rank) {
        return spectrum_.data() + static_cast<std::ptrdiff_t>(modes_of(rank).first) * slab_.count * row_;
    }
    /// Coefficients of x mode m in plane k of this rank.
    double* coefficients(int m, int k) {
        if (!distributed()) return column_.data() + (static_cast<std::ptrdiff_t>(k) * modes_.count + m) * row_;
        const int rank = rank_of_plane(m, grid_.cells[0], ranks_);
        const Slab modes = modes_of(rank);
        return spectrum_of(rank) + (static_cast<std::ptrdiff_t>(k) * modes.count + (m - modes.first)) * row_;
    }

    template <class Source> void transform_plane(const Helmholtz& equation, int k, Work& w, Source&& source) {
        const LineTransform &x = equation.x, &y = equation.y;
        const int nx = grid_.cells[0], ny = grid_.cells[1];
        for (int i = 0; i < nx; i += y.lanes()) {
            for (int j = 0; j < ny; ++j) {
                double* to = &w.in[static_cast<std::size_t>(y.place(j) * y.lanes())];
                const P sign(y.sign(j));
                for (int l = 0; l < y.lanes(); l += 8) store(to + l, sign * first_lanes(source(i + l, j, k), nx - i - l));
            }
            y.forward(w.in.data(), w.out.data());
            for (int j = 0; j < ny; ++j)
                for (int l = 0; l < y.lanes(); l += 8)
                    store(&w.plane[static_cast<std::size_t>(j * wide_ + i + l)],
                          load<8>(&w.out[static_cast<std::size_t>(j * y.lanes() + l)]));
        }
        for (int j = 0; j < ny; j += x.lanes()) {
            for (int i = 0; i < nx; i += 8)
                for (int l = 0; l < x.lanes(); l += 8) {
                    P square[8];
                    for (int t = 0; t < 8; ++t) square[t] = load<8>(&w.plane[static_cast<std::size_t>((j + l + t) * wide_ + i)]);
                    transpose(square);
                    for (int t = 0; t < std::min(8, nx - i); ++t)
                        store(&w.in[static_cast<std::size_t>(x.place(i + t) * x.lanes() + l)], P(x.sign(i + t)) * square[t]);
                }
            x.forward(w.in.data(), w.out.data());
            for (int m = 0; m < nx; ++m) {
                double* to = coefficients(m, k) + j;
                for (int l = 0; l < x.lanes(); l += 8) store(to + l, load<8>(&w.out[static_cast<std::size_t>(m * x.lanes() + l)]));
            }
        }
    }

    template <class Sink> void transform_plane_back(const Helmholtz& equation, int k, Work& w, Sink&& sink) {
        const LineTransform &x = equation.x, &y = equation.y;
        const int nx = grid_.cells[0], ny = grid_.cells[1];
        for (int j = 0; j < ny; j += x.lanes()) {
            for (int m = 0; m < nx; ++m) {
                const double* from = coefficients(m, k) + j;
                for (int l = 0; l < x.lanes(); l += 8) store(&w.in[static_cast<std::size_t>(m * x.lanes() + l)], load<8>(from + l));
            }
            x.inverse(w.in.data(), w.out.data());
            for (int i = 0; i < nx; i += 8)
                for (int l = 0; l < x.lanes(); l += 8) {
                    P square[8];
                    for (int t = 0; t < 8; ++t)
                        square[t] = i + t < nx ? P(x.sign(i + t)) *
                                                     load<8>(&w.out[static_cast<std::size_t>(x.place(i + t) * x.lanes() + l)])
                                               : P(0.0);
                    transpose(square);
                    for (int t = 0; t < std::min(8, ny - j - l); ++t)
                        store(&w.plane[static_cast<std::size_t>((j + l + t) * wide_ + i)], square[t]);
                }
        }
        for (int i = 0; i < nx; i += y.lanes()) {
            for (int j = 0; j < ny; ++j)
                for (int l = 0; l < y.lanes(); l += 8)
                    store(&w.in[static_cast<std::size_t>(j * y.lanes() + l)],
                          load<8>(&w.plane[static_cast<std::size_t>(j * wide_ + i + l)]));
            y.inverse(w.in.data(), w.out.data());
            for (int j = 0; j < ny; ++j)
                for (int l = 0; l < std::min(y.lanes(), nx - i); l += 8)
                    sink(i + l, j, k, P(y.sign(j)) * load<8>(&w.out[static_cast<std::size_t>(y.place(j) * y.lanes() + l)]));
        }
    }

    /// The tridiagonal systems of x mode m of this rank: pivots from the first plane on, then back.
    void solve_columns(const Helmholtz& equation, int m, Work& w) {
        const int nz = grid_.cells[2], ny = grid_.cells[1];
        const LineTransform &x = equation.x, &y = equation.y;
        // Beyond an end the value is that of the outer number, its opposite, or 0: that much more in the diagonal.
        const P end(equation.z == LineEnds::gradient_zero ? 1.0 : equation.z == LineEnds::value_zero ? -1.0 : 0.0);
        const int unknown = equation.z == LineEnds::faces_zero ? nz - 1 : nz;
        const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(modes_.count) * row_;
        const double scale = equation.scale / (x.gain() * y.gain()), of_x = x.eigenvalue(modes_.first + m);
        for (int j = 0; j < row_; j += chunk) {
            const int lanes = std::min<int>(chunk, row_ - j);
            double* const first = column_.data() + static_cast<std::ptrdiff_t>(m) * row_ + j;
            P diagonal[chunk / 8];
            for (int l = 0; l < lanes; ++l) {
                const int at = j + l;
                diagonal[l / 8].set(l % 8, at < ny ? of_x + y.eigenvalue(at) - 2 + equation.shift : -3.0);
            }
            for (int l = 0; l < lanes; l += 8) {
                if (equation.z == LineEnds::periodic)
                    solve_period(first + l, plane, nz, P(scale), diagonal[l / 8], &w.pivot[static_cast<std::size_t>(l)],
                                 &w.last[static_cast<std::size_t>(l)]);
                else
                    solve_between(first + l, plane, unknown, P(scale), diagonal[l / 8], end, &w.pivot[static_cast<std::size_t>(l)]);
                if (unknown < nz) store(first + l + unknown * plane, P(0.0));
            }
        }
    }
    /// A pivot that is 0 but for rounding is that of the constant, which is free: it is taken as 0.
    SKEIN_INLINE static P inverse_of(P pivot) {
        const Mask<8> some = abs(pivot) > P(1e-11);
        return select(some, P(1.0) / select(some, pivot, P(1.0)), P(0.0));
    }
    static void solve_between(double* f, std::ptrdiff_t plane, int nz, P scale, P diagonal, P end, double* pivots) {
        P pivot(0.0), value(0.0);
        for (int k = 0; k < nz; ++k) {
            const P ends = (k == 0 ? end : P(0.0)) + (k == nz - 1 ? end : P(0.0));
            pivot = inverse_of(diagonal + ends - pivot);
            value = fms(scale, load<8>(f + k * plane), value) * pivot;
            store(pivots + k * chunk, pivot), store(f + k * plane, value);
        }
        for (int k = nz - 2; k >= 0; --k) {
            value = fnma(load<8>(pivots + k * chunk), value, load<8>(f + k * plane));
            store(f + k * plane, value);
        }
    }
    /// All but the last unknown by that one, x_k = y_k + z_k x_last; then that.
    static void solve_period(double* f, std::ptrdiff_t plane, int nz, P scale, P diagonal, double* pivots, double* last) {
        if (nz == 1) {
            store(f, scale * load<8>(f) * inverse_of(diagonal + P(2.0)));
            return;
        }
        if (nz == 2) { // both neighbours are the same cell
            const P a = scale * load<8>(f), b = scale * load<8>(f + plane), sum = (a + b) * inverse_of(diagonal + P(2.0)),
                    difference = (a - b) * inverse_of(diagonal - P(2.0));
            store(f, P(0.5) * (sum + difference)), store(f + plane, P(0.5) * (sum - difference));
            return;
        }
        const int n = nz - 1;
        P pivot(0.0), y(0.0), z(0.0);
        for (int k = 0; k < n; ++k) {
            pivot = inverse_of(diagonal - pivot);
            y = fms(scale, load<8>(f + k * plane), y) * pivot;
            z = ((k == 0 ? P(-1.0) : P(0.0)) + (k == n - 1 ? P(-1.0) : P(0.0)) - z) * pivot;
            store(pivots + k * chunk, pivot), store(f + k * plane, y), store(last + k * chunk, z);
        }
        const P y_end = y, z_end = z;
        for (int k = n - 2; k >= 0; --k) {
            const P p = load<8>(pivots + k * chunk);
            y = fnma(p, y, load<8>(f + k * plane)), z = fnma(p, z, load<8>(last + k * chunk));
            store(f + k * plane, y), store(last + k * chunk, z);
        }
        const P x = (scale * load<8>(f + n * plane) - y_end - y) * inverse_of(diagonal + z_end + z);
        store(f + n * plane, x);
        for (int k = 0; k < n; ++k) store(f + k * plane, fma(load<8>(last + k * chunk), x, load<8>(f + k * plane)));
    }

    const Threads& threads_;
    FluidGrid grid_;
    int ranks_;
    Slab slab_;
    Slab modes_; ///< along x, whose columns this rank solves
    int row_;    ///< coefficients along y, with room to whole packs
    std::ptrdiff_t wide_ = 0;
    UnsetArray<double> column_;   ///< [z][mode][row]
    UnsetArray<double> spectrum_; ///< [rank][plane][mode][row], to be sent; none on one rank
    RepeatedMessages to_columns_, to_planes_;
    std::vector<Work> work_; ///< by thread
};

} // namespace skein
