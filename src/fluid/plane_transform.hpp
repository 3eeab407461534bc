// Transforms of planes of cells along x and along y. theory.md (78), (79)
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/helmholtz.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <vector>

namespace skein {

/// Addresses of rows along x: row j of plane k begins at first[j] + k plane[j].
struct PlaneRows {
    std::vector<double*> first;
    std::vector<std::ptrdiff_t> plane;

    void add(double* row, std::ptrdiff_t to_next_plane) {
        first.push_back(row);
        plane.push_back(to_next_plane);
    }
    double* at(int j, int k) const {
        const std::size_t row = to_index(j);
        return first[row] + k * plane[row];
    }
};

/// Addresses of packs of eight coefficients: pack p of row j of plane k begins at first[p] + k plane[p] + j row[p].
struct PlanePacks {
    std::vector<double*> first;
    std::vector<std::ptrdiff_t> plane, row;

    void add(double* pack, std::ptrdiff_t to_next_plane, std::ptrdiff_t to_next_row) {
        first.push_back(pack);
        plane.push_back(to_next_plane);
        row.push_back(to_next_row);
    }
};

/// Length of a row of coefficients along x in whole blocks.
inline int row_of(int modes) { return (modes + 15) / 16 * 16; }

/// Coefficients of a plane after transforms along x, in blocks of 8 or 16 adjacent rows. Address at(j, m) is that of
/// eight rows from j on; the next mode is `lanes` further.
struct PlaneTiles {
    double* first;
    std::ptrdiff_t row;
    int lanes;
    double* at(int j, int m) const {
        const int within = j & (lanes - 1);
        return first + (j - within) * row + static_cast<std::ptrdiff_t>(m) * lanes + within;
    }
};

/// Memory for a block of lines before and after a transform.
struct LineBlocks {
    AlignedVector<double> in, out;

    void make_room(const LineTransform& line) {
        if (in.size() < line.block()) {
            in.resize(line.block());
            out.resize(line.block());
        }
    }
};

/// Transform of rows of cells by one thread, which reads and writes a plane in one sweep.
class TransformAlongX {
public:
    using P = Pack<8>;
    TransformAlongX(int nx, int rows) : nx_(nx), rows_(rows), wide_(row_of(nx)) {
        plane_.assign(to_index(row_of(rows) * wide_), 0.0);
    }

    /// source(i, j, k) returns eight cells from (i, j, k) on; cells beyond the row are ignored.
    template <class Source> void forward(const LineTransform& x, int k, const PlanePacks& to, Source&& source) {
        read(x, k, source);
        for (int j = 0; j < rows_; j += x.lanes()) {
            gather(x, j);
            x.forward(blocks_.in.data(), blocks_.out.data());
            for_squares(x, j, [&](int m, int l) {
                const std::size_t pack = to_index(m / 8);
                double* const first = to.first[pack] + k * to.plane[pack] + (j + l) * to.row[pack];
                P square[8];
                for (int t = 0; t < 8; ++t)
                    square[t] = m + t < nx_ ? load<8>(&nth(blocks_.out, (m + t) * x.lanes() + l)) : P(0.0);
                transpose(square);
                for (int t = 0; t < 8; ++t)
                    if (j + l + t < rows_) store(first + t * to.row[pack], square[t]);
            });
        }
    }
    /// Transforms to tiles() of a plane, which stay in this object.
    template <class Source> void forward(const LineTransform& x, int k, Source&& source) {
        read(x, k, source);
        const bool longer = x.block() > tile_size(x);
        for (int j = 0; j < rows_; j += x.lanes()) {
            gather(x, j);
            x.forward(blocks_.in.data(), longer ? blocks_.out.data() : row(j));
            if (longer) std::copy_n(blocks_.out.data(), tile_size(x), row(j));
        }
    }
    PlaneTiles tiles(const LineTransform& x) { return {plane_.data(), wide_, x.lanes()}; }

    /// sink(i, j, k, numbers) takes eight cells from (i, j, k) on.
    template <class Sink> void back(const LineTransform& x, int k, const PlanePacks& from, Sink&& sink) {
        blocks_.make_room(x);
        for (int j = 0; j < rows_; j += x.lanes()) {
            for_squares(x, j, [&](int m, int l) {
                const std::size_t pack = to_index(m / 8);
                const double* const first = from.first[pack] + k * from.plane[pack] + (j + l) * from.row[pack];
                P square[8];
                for (int t = 0; t < 8; ++t)
                    square[t] = j + l + t < rows_ ? load<8>(first + t * from.row[pack]) : P(0.0);
                transpose(square);
                for (int t = 0; t < 8; ++t)
                    if (m + t < nx_) store(&nth(blocks_.in, (m + t) * x.lanes() + l), square[t]);
            });
            x.inverse(blocks_.in.data(), blocks_.out.data());
            scatter(x, j);
        }
        write(k, sink);
    }
    /// Transforms back from tiles().
    template <class Sink> void back(const LineTransform& x, int k, Sink&& sink) {
        blocks_.make_room(x);
        const bool longer = x.block() > tile_size(x);
        for (int j = 0; j < rows_; j += x.lanes()) {
            if (longer) std::copy_n(row(j), tile_size(x), blocks_.in.data());
            x.inverse(longer ? blocks_.in.data() : row(j), blocks_.out.data());
            scatter(x, j);
        }
        write(k, sink);
    }

private:
    double* row(int j) { return plane_.data() + static_cast<std::ptrdiff_t>(j) * wide_; }
    std::size_t tile_size(const LineTransform& x) const { return to_index(nx_ * x.lanes()); }
    template <class Source> void read(const LineTransform& x, int k, Source&& source) {
        blocks_.make_room(x);
        for (int j = 0; j < rows_; ++j)
            for (int i = 0; i < nx_; i += 8) store(row(j) + i, first_lanes(source(i, j, k), nx_ - i));
        for (int j = rows_; j % x.lanes() != 0; ++j) std::fill_n(row(j), wide_, 0.0); // clears tiles
    }
    template <class Sink> void write(int k, Sink&& sink) {
        for (int j = 0; j < rows_; ++j)
            for (int i = 0; i < nx_; i += 8) sink(i, j, k, load<8>(row(j) + i));
    }
    /// Calls body(i, l) for squares of eight numbers from i on in eight rows from j + l on.
    template <class Body> void for_squares(const LineTransform& x, int j, Body&& body) const {
        for (int i = 0; i < nx_; i += 8)
            for (int l = 0; l < std::min(x.lanes(), rows_ - j); l += 8) body(i, l);
    }
    /// Copies a block of rows from j on for the transform.
    void gather(const LineTransform& x, int j) {
        for (int i = 0; i < nx_; i += 8)
            for (int l = 0; l < x.lanes(); l += 8) {
                P square[8];
                for (int t = 0; t < 8; ++t) square[t] = load<8>(row(j + l + t) + i);
                transpose(square);
                for (int t = 0; t < 8; ++t)
                    if (i + t < nx_)
                        store(&nth(blocks_.in, x.place(i + t) * x.lanes() + l), P(x.sign(i + t)) * square[t]);
            }
    }
    void scatter(const LineTransform& x, int j) {
        for_squares(x, j, [&](int i, int l) {
            P square[8];
            for (int t = 0; t < 8; ++t)
                square[t] = i + t < nx_ ? P(x.sign(i + t)) * load<8>(&nth(blocks_.out, x.place(i + t) * x.lanes() + l))
                                        : P(0.0);
            transpose(square);
            for (int t = 0; t < 8; ++t) store(row(j + l + t) + i, square[t]);
        });
    }

    int nx_, rows_, wide_;
    AlignedVector<double> plane_; ///< [row][x] in whole blocks of rows, or tiles
    LineBlocks blocks_;
};

/// Transform along y of coefficients along x by one thread.
class TransformAlongY {
public:
    using P = Pack<8>;
    explicit TransformAlongY(int modes) : modes_(modes) {}

    /// Writes rows of whole blocks.
    void forward(const LineTransform& y, int k, const PlaneRows& from, const PlaneRows& to) {
        transform(y, k, to, [&](int m) {
            for (int j = 0; j < y.size(); ++j)
                for (int l = 0; l < y.lanes(); l += 8)
                    store(in(y, j, l), m + l < modes_ ? P(y.sign(j)) * load<8>(from.at(j, k) + m + l) : P(0.0));
        });
    }
    void forward(const LineTransform& y, int k, const PlaneTiles& from, const PlaneRows& to) {
        transform(y, k, to, [&](int m) {
            for_squares(y, [&](int j, int l) {
                const double* const tile = from.at(j, m + l);
                P square[8];
                for (int t = 0; t < 8; ++t) square[t] = m + l + t < modes_ ? load<8>(tile + t * from.lanes) : P(0.0);
                transpose(square);
                for (int t = 0; t < 8; ++t)
                    if (j + t < y.size()) store(in(y, j + t, l), P(y.sign(j + t)) * square[t]);
            });
        });
    }

    /// Reads rows of whole blocks.
    void back(const LineTransform& y, int k, const PlaneRows& from, const PlaneRows& to) {
        transform_back(y, k, from, [&](int m) {
            for (int j = 0; j < y.size(); ++j)
                for (int l = 0; l < std::min(y.lanes(), modes_ - m); l += 8)
                    store(to.at(j, k) + m + l, P(y.sign(j)) * load<8>(out(y, j, l)));
        });
    }
    void back(const LineTransform& y, int k, const PlaneRows& from, const PlaneTiles& to) {
        transform_back(y, k, from, [&](int m) {
            for_squares(y, [&](int j, int l) {
                double* const tile = to.at(j, m + l);
                P square[8];
                for (int t = 0; t < 8; ++t)
                    square[t] = j + t < y.size() ? P(y.sign(j + t)) * load<8>(out(y, j + t, l)) : P(0.0);
                transpose(square);
                for (int t = 0; t < 8; ++t)
                    if (m + l + t < modes_) store(tile + t * to.lanes, square[t]);
            });
        });
    }

private:
    double* in(const LineTransform& y, int j, int l) { return &nth(blocks_.in, y.place(j) * y.lanes() + l); }
    const double* out(const LineTransform& y, int j, int l) const {
        return &nth(blocks_.out, y.place(j) * y.lanes() + l);
    }
    /// Calls body(j, l) for squares of eight numbers from j on of eight modes from l on.
    template <class Body> static void for_squares(const LineTransform& y, Body&& body) {
        for (int j = 0; j < y.size(); j += 8)
            for (int l = 0; l < y.lanes(); l += 8) body(j, l);
    }
    /// gather(m) copies modes from m on for the transform.
    template <class Gather> void transform(const LineTransform& y, int k, const PlaneRows& to, Gather&& gather) {
        blocks_.make_room(y);
        for (int m = 0; m < modes_; m += y.lanes()) {
            gather(m);
            y.forward(blocks_.in.data(), blocks_.out.data());
            for (int j = 0; j < y.size(); ++j) {
                double* const row = to.at(j, k) + m;
                for (int l = 0; l < y.lanes(); l += 8) {
                    __builtin_prefetch(row + y.lanes() + l, 1, 2);
                    store(row + l, load<8>(&nth(blocks_.out, j * y.lanes() + l)));
                }
            }
        }
    }
    /// scatter(m) takes modes from m on after the transform.
    template <class Scatter>
    void transform_back(const LineTransform& y, int k, const PlaneRows& from, Scatter&& scatter) {
        blocks_.make_room(y);
        for (int m = 0; m < modes_; m += y.lanes()) {
            for (int j = 0; j < y.size(); ++j) {
                const double* const row = from.at(j, k) + m;
                for (int l = 0; l < y.lanes(); l += 8) {
                    __builtin_prefetch(row + y.lanes() + l, 0, 2);
                    store(&nth(blocks_.in, j * y.lanes() + l), load<8>(row + l));
                }
            }
            y.inverse(blocks_.in.data(), blocks_.out.data());
            scatter(m);
        }
    }

    int modes_;
    LineBlocks blocks_;
};

} // namespace skein
