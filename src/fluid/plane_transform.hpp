// Transforms of a plane of cells along y and x, to coefficients and back.                                     theory.md (78), (79)
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/helmholtz.hpp"
#include "skein/core/aligned.hpp"

#include <algorithm>
#include <vector>

namespace skein {

/// Where coefficients of planes lie: those of x mode m in plane k from first[m] + k plane[m] on, row_of() of them along y.
struct CoefficientRows {
    std::vector<double*> first;
    std::vector<std::ptrdiff_t> plane;

    double* at(int m, int k) const {
        const auto mode = static_cast<std::size_t>(m);
        return first[mode] + k * plane[mode];
    }
};

/// Coefficients along y, with room to whole blocks.
inline int row_of(const FluidGrid& grid) { return (grid.cells[1] + 15) / 16 * 16; }

/// By one thread.
class PlaneTransform {
public:
    using P = Pack<8>;
    explicit PlaneTransform(const FluidGrid& grid) : nx_(grid.cells[0]), ny_(grid.cells[1]), wide_((nx_ + 15) / 16 * 16) {
        plane_.assign(static_cast<std::size_t>(row_of(grid) * wide_), 0.0);
    }

    /// source(i, j, k): numbers of eight cells from (i, j, k) on, of which those beyond the row are left out.
    template <class Source> void forward(const Helmholtz& equation, int k, const CoefficientRows& to, Source&& source) {
        const LineTransform &x = equation.x, &y = equation.y;
        make_room(equation);
        for (int j = 0; j < ny_; ++j) { // by rows, as they are read from memory
            double* const row = &plane_[static_cast<std::size_t>(j * wide_)];
            const P sign(y.sign(j));
            for (int i = 0; i < wide_; i += 8) store(row + i, sign * first_lanes(source(i, j, k), nx_ - i));
        }
        for (int i = 0; i < nx_; i += y.lanes()) {
            for (int j = 0; j < ny_; ++j) {
                double* const row = &in_[static_cast<std::size_t>(y.place(j) * y.lanes())];
                for (int l = 0; l < y.lanes(); l += 8)
                    store(row + l, load<8>(&plane_[static_cast<std::size_t>(j * wide_ + i + l)]));
            }
            y.forward(in_.data(), out_.data());
            for (int j = 0; j < ny_; ++j)
                for (int l = 0; l < y.lanes(); l += 8)
                    store(&plane_[static_cast<std::size_t>(j * wide_ + i + l)],
                          load<8>(&out_[static_cast<std::size_t>(j * y.lanes() + l)]));
        }
        for (int j = 0; j < ny_; j += x.lanes()) {
            for (int i = 0; i < nx_; i += 8)
                for (int l = 0; l < x.lanes(); l += 8) {
                    P square[8];
                    for (int t = 0; t < 8; ++t) square[t] = load<8>(&plane_[static_cast<std::size_t>((j + l + t) * wide_ + i)]);
                    transpose(square);
                    for (int t = 0; t < std::min(8, nx_ - i); ++t)
                        store(&in_[static_cast<std::size_t>(x.place(i + t) * x.lanes() + l)], P(x.sign(i + t)) * square[t]);
                }
            x.forward(in_.data(), out_.data());
            for (int m = 0; m < nx_; ++m) {
                double* const row = to.at(m, k) + j;
                for (int l = 0; l < x.lanes(); l += 8) {
                    __builtin_prefetch(row + x.lanes() + l, 1, 2);
                    store(row + l, load<8>(&out_[static_cast<std::size_t>(m * x.lanes() + l)]));
                }
            }
        }
    }

    /// sink(i, j, k, numbers): takes them there.
    template <class Sink> void back(const Helmholtz& equation, int k, const CoefficientRows& from, Sink&& sink) {
        const LineTransform &x = equation.x, &y = equation.y;
        make_room(equation);
        for (int j = 0; j < ny_; j += x.lanes()) {
            for (int m = 0; m < nx_; ++m) {
                const double* const row = from.at(m, k) + j;
                for (int l = 0; l < x.lanes(); l += 8) {
                    __builtin_prefetch(row + x.lanes() + l, 0, 2);
                    store(&in_[static_cast<std::size_t>(m * x.lanes() + l)], load<8>(row + l));
                }
            }
            x.inverse(in_.data(), out_.data());
            for (int i = 0; i < nx_; i += 8)
                for (int l = 0; l < x.lanes(); l += 8) {
                    P square[8];
                    for (int t = 0; t < 8; ++t)
                        square[t] = i + t < nx_ ? P(x.sign(i + t)) *
                                                      load<8>(&out_[static_cast<std::size_t>(x.place(i + t) * x.lanes() + l)])
                                                : P(0.0);
                    transpose(square);
                    for (int t = 0; t < std::min(8, ny_ - j - l); ++t)
                        store(&plane_[static_cast<std::size_t>((j + l + t) * wide_ + i)], square[t]);
                }
        }
        for (int i = 0; i < nx_; i += y.lanes()) {
            for (int j = 0; j < ny_; ++j)
                for (int l = 0; l < y.lanes(); l += 8)
                    store(&in_[static_cast<std::size_t>(j * y.lanes() + l)],
                          load<8>(&plane_[static_cast<std::size_t>(j * wide_ + i + l)]));
            y.inverse(in_.data(), out_.data());
            for (int j = 0; j < ny_; ++j)
                for (int l = 0; l < y.lanes(); l += 8)
                    store(&plane_[static_cast<std::size_t>(j * wide_ + i + l)],
                          P(y.sign(j)) * load<8>(&out_[static_cast<std::size_t>(y.place(j) * y.lanes() + l)]));
        }
        for (int j = 0; j < ny_; ++j) // by rows, as they are written to memory
            for (int i = 0; i < nx_; i += 8) sink(i, j, k, load<8>(&plane_[static_cast<std::size_t>(j * wide_ + i)]));
    }

private:
    void make_room(const Helmholtz& equation) {
        const std::size_t most = std::max(equation.x.block(), equation.y.block());
        if (in_.size() < most) in_.resize(most), out_.resize(most);
    }

    int nx_, ny_;
    std::ptrdiff_t wide_;
    AlignedVector<double> plane_;    ///< [y][x]
    AlignedVector<double> in_, out_; ///< of a transform
};

} // namespace skein
