// Transforms of planes of cells along x and along y, to coefficients and back.                               theory.md (78), (79)
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/helmholtz.hpp"
#include "skein/core/aligned.hpp"

#include <algorithm>
#include <vector>

namespace skein {

/// Where numbers of planes lie, in rows along x: those of row j in plane k from first[j] + k plane[j] on.
struct PlaneRows {
    std::vector<double*> first;
    std::vector<std::ptrdiff_t> plane;

    void add(double* row, std::ptrdiff_t to_next_plane) { first.push_back(row), plane.push_back(to_next_plane); }
    double* at(int j, int k) const {
        const auto row = static_cast<std::size_t>(j);
        return first[row] + k * plane[row];
    }
};

/// The same of rows whose packs of eight coefficients may lie apart: those of pack p of row j in plane k from
/// first[p] + k plane[p] + j row[p] on.
struct PlanePacks {
    std::vector<double*> first;
    std::vector<std::ptrdiff_t> plane, row;

    void add(double* pack, std::ptrdiff_t to_next_plane, std::ptrdiff_t to_next_row) {
        first.push_back(pack), plane.push_back(to_next_plane), row.push_back(to_next_row);
    }
};

/// Room for so many coefficients along x, of whole blocks.
inline int row_of(int modes) { return (modes + 15) / 16 * 16; }

/// Room for a block of lines before and after a transform.
struct LineBlocks {
    AlignedVector<double> in, out;

    void make_room(const LineTransform& line) {
        if (in.size() < line.block()) in.resize(line.block()), out.resize(line.block());
    }
};

/// Of rows of cells, by one thread.
class TransformAlongX {
public:
    using P = Pack<8>;
    TransformAlongX(int nx, int rows) : nx_(nx), rows_(rows), wide_(row_of(nx)) {}

    /// source(i, j, k): numbers of eight cells from (i, j, k) on, of which those beyond the row are left out.
    template <class Source> void forward(const LineTransform& x, int k, const PlanePacks& to, Source&& source) {
        make_room(x);
        for (int j = 0; j < rows_; j += x.lanes()) {
            const int rows = std::min(x.lanes(), rows_ - j);
            for (int r = 0; r < rows; ++r) // as they are read from memory
                for (int i = 0; i < nx_; i += 8) store(row(r) + i, first_lanes(source(i, j + r, k), nx_ - i));
            for (int r = rows; r < x.lanes(); ++r) std::fill_n(row(r), nx_, 0.0);
            for (int i = 0; i < nx_; i += 8)
                for (int l = 0; l < x.lanes(); l += 8) {
                    P square[8];
                    for (int t = 0; t < 8; ++t) square[t] = load<8>(row(l + t) + i);
                    transpose(square);
                    for (int t = 0; t < std::min(8, nx_ - i); ++t)
                        store(&blocks_.in[static_cast<std::size_t>(x.place(i + t) * x.lanes() + l)], P(x.sign(i + t)) * square[t]);
                }
            x.forward(blocks_.in.data(), blocks_.out.data());
            for (int m = 0; m < nx_; m += 8) {
                const auto pack = static_cast<std::size_t>(m / 8);
                double* const first = to.first[pack] + k * to.plane[pack] + j * to.row[pack];
                for (int l = 0; l < rows; l += 8) {
                    P square[8];
                    for (int t = 0; t < 8; ++t)
                        square[t] = m + t < nx_ ? load<8>(&blocks_.out[static_cast<std::size_t>((m + t) * x.lanes() + l)]) : P(0.0);
                    transpose(square);
                    for (int t = 0; t < std::min(8, rows - l); ++t) store(first + (l + t) * to.row[pack], square[t]);
                }
            }
        }
    }

    /// sink(i, j, k, numbers): takes them there.
    template <class Sink> void back(const LineTransform& x, int k, const PlanePacks& from, Sink&& sink) {
        make_room(x);
        for (int j = 0; j < rows_; j += x.lanes()) {
            const int rows = std::min(x.lanes(), rows_ - j);
            for (int m = 0; m < nx_; m += 8) {
                const auto pack = static_cast<std::size_t>(m / 8);
                const double* const first = from.first[pack] + k * from.plane[pack] + j * from.row[pack];
                for (int l = 0; l < x.lanes(); l += 8) {
                    P square[8];
                    for (int t = 0; t < 8; ++t) square[t] = l + t < rows ? load<8>(first + (l + t) * from.row[pack]) : P(0.0);
                    transpose(square);
                    for (int t = 0; t < std::min(8, nx_ - m); ++t)
                        store(&blocks_.in[static_cast<std::size_t>((m + t) * x.lanes() + l)], square[t]);
                }
            }
            x.inverse(blocks_.in.data(), blocks_.out.data());
            for (int i = 0; i < nx_; i += 8)
                for (int l = 0; l < rows; l += 8) {
                    P square[8];
                    for (int t = 0; t < 8; ++t)
                        square[t] =
                            i + t < nx_
                                ? P(x.sign(i + t)) * load<8>(&blocks_.out[static_cast<std::size_t>(x.place(i + t) * x.lanes() + l)])
                                : P(0.0);
                    transpose(square);
                    for (int t = 0; t < 8; ++t) store(row(l + t) + i, square[t]);
                }
            for (int r = 0; r < rows; ++r) // as they are written to memory
                for (int i = 0; i < nx_; i += 8) sink(i, j + r, k, load<8>(row(r) + i));
        }
    }

private:
    void make_room(const LineTransform& x) {
        blocks_.make_room(x);
        numbers_.resize(static_cast<std::size_t>(x.lanes() * wide_));
    }
    double* row(int r) { return &numbers_[static_cast<std::size_t>(r * wide_)]; }

    int nx_, rows_, wide_;
    AlignedVector<double> numbers_; ///< [row of a block][x]
    LineBlocks blocks_;
};

/// Of coefficients along x, each along the whole of y, by one thread.
class TransformAlongY {
public:
    using P = Pack<8>;
    explicit TransformAlongY(int modes) : modes_(modes) {}

    /// Rows of whole blocks come out.
    void forward(const LineTransform& y, int k, const PlaneRows& from, const PlaneRows& to) {
        blocks_.make_room(y);
        for (int m = 0; m < modes_; m += y.lanes()) {
            for (int j = 0; j < y.size(); ++j) {
                const double* const row = from.at(j, k) + m;
                double* const place = &blocks_.in[static_cast<std::size_t>(y.place(j) * y.lanes())];
                const P sign(y.sign(j));
                for (int l = 0; l < y.lanes(); l += 8) store(place + l, m + l < modes_ ? sign * load<8>(row + l) : P(0.0));
            }
            y.forward(blocks_.in.data(), blocks_.out.data());
            for (int j = 0; j < y.size(); ++j) {
                double* const row = to.at(j, k) + m;
                for (int l = 0; l < y.lanes(); l += 8) {
                    __builtin_prefetch(row + y.lanes() + l, 1, 2);
                    store(row + l, load<8>(&blocks_.out[static_cast<std::size_t>(j * y.lanes() + l)]));
                }
            }
        }
    }
    /// `from`: rows of whole blocks.
    void back(const LineTransform& y, int k, const PlaneRows& from, const PlaneRows& to) {
        blocks_.make_room(y);
        for (int m = 0; m < modes_; m += y.lanes()) {
            for (int j = 0; j < y.size(); ++j) {
                const double* const row = from.at(j, k) + m;
                for (int l = 0; l < y.lanes(); l += 8) {
                    __builtin_prefetch(row + y.lanes() + l, 0, 2);
                    store(&blocks_.in[static_cast<std::size_t>(j * y.lanes() + l)], load<8>(row + l));
                }
            }
            y.inverse(blocks_.in.data(), blocks_.out.data());
            for (int j = 0; j < y.size(); ++j) {
                double* const row = to.at(j, k) + m;
                const double* const place = &blocks_.out[static_cast<std::size_t>(y.place(j) * y.lanes())];
                for (int l = 0; l < std::min(y.lanes(), modes_ - m); l += 8) store(row + l, P(y.sign(j)) * load<8>(place + l));
            }
        }
    }

private:
    int modes_;
    LineBlocks blocks_;
};

} // namespace skein
