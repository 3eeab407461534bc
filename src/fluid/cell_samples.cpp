#include "fluid/cell_samples.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace skein {

namespace {

/// Planes of cubes whose last planes of cells belong to a slab.
Slab own_planes(const CellBox& box, const Slab& slab) {
    const auto ended_before = [&](int plane) {
        return std::clamp((plane - box.first[2]) / box.average, 0, box.count[2]);
    };
    const int from = slab.first <= box.first[2] ? 0 : ended_before(slab.first), end = slab.first + slab.count;
    return {from, (end <= box.first[2] ? 0 : ended_before(end)) - from};
}

} // namespace

BoxSampler::BoxSampler(const Communicator& comm, const Threads& threads, const FlowPlanes& flow, const CellBox& box)
    : comm_(comm), threads_(threads), flow_(flow), box_(box), slab_(flow.planes()), planes_(own_planes(box, slab_)) {}

std::size_t BoxSampler::row_numbers() const { return to_index(box_.count[0]) * to_index(entry_of(field_).components); }

void BoxSampler::add_row(int k, int row, std::span<double> scratch, std::span<double> sum) const {
    const CellReader reader(flow_);
    const int n = box_.average, cells = n * box_.count[0];
    const std::size_t components = to_index(entry_of(field_).components);
    for (int j = 0; j < n; ++j) {
        reader.row(field_, box_.first[0], box_.first[1] + row * n + j, k, cells, scratch.data());
        for (std::size_t cube = 0, at = 0; cube < to_index(box_.count[0]); ++cube)
            for (int i = 0; i < n; ++i)
                for (std::size_t c = 0; c < components; ++c) sum[cube * components + c] += scratch[at++];
    }
}

void BoxSampler::begin(CellField field) {
    field_ = field;
    const int n = box_.average, above = planes_.first + planes_.count; // plane of cubes that belongs to the next ranks
    const std::size_t numbers = row_numbers() * to_index(box_.count[1]);
    std::vector<std::int64_t> to(to_index(comm_.size()), 0), from;
    std::vector<double> sums;
    if (above < box_.count[2]) {
        const int first = std::max(begin_of(above), 0), planes = std::max(slab_.count - first, 0);
        const int last_cell = box_.first[2] + (above + 1) * n - 1;
        nth(to, rank_of_plane(last_cell, flow_.constants().grid.cells[2], comm_.size())) = planes;
        sums.assign(to_index(planes) * numbers, 0);
        threads_.for_each(to_index(planes * box_.count[1]), [&](std::size_t item, int) {
            const int k = static_cast<int>(item) / box_.count[1], row = static_cast<int>(item) % box_.count[1];
            std::vector<double> scratch(to_index(n) * row_numbers());
            add_row(first + k, row, scratch, std::span(sums).subspan(item * row_numbers(), row_numbers()));
        });
    }
    const std::size_t record = numbers * sizeof(double);
    const std::vector<std::byte> arrived = comm_.all_to_all(std::as_bytes(std::span(sums)), record, to, from);
    from_below_.resize(arrived.size() / sizeof(double));
    if (!arrived.empty()) std::memcpy(from_below_.data(), arrived.data(), arrived.size());
}

void BoxSampler::sample(int first, int count, std::span<double> out) const {
    const int n = box_.average, rows = box_.count[1];
    const std::size_t numbers = row_numbers();
    threads_.for_each(to_index(count * rows), [&](std::size_t item, int) {
        const int plane = first + static_cast<int>(item) / rows, row = static_cast<int>(item) % rows;
        const std::span<double> mean = out.subspan(item * numbers, numbers);
        std::vector<double> scratch(to_index(n) * numbers), sum(numbers);
        std::fill(mean.begin(), mean.end(), 0);
        const auto add = [&](const double* values) {
            for (std::size_t i = 0; i < numbers; ++i) mean[i] += values[i];
        };
        if (plane == 0)
            for (std::size_t at = to_index(row) * numbers; at < from_below_.size(); at += numbers * to_index(rows))
                add(from_below_.data() + at);
        const int begin = begin_of(planes_.first + plane);
        for (int k = std::max(begin, 0); k < begin + n; ++k) {
            std::fill(sum.begin(), sum.end(), 0);
            add_row(k, row, scratch, sum);
            add(sum.data());
        }
        for (double& x : mean) x /= static_cast<double>(n) * n * n;
    });
}

BlockSampler::BlockSampler(const Communicator& comm, const Threads& threads, const FlowPlanes& flow, int edge)
    : comm_(comm), threads_(threads), flow_(flow), edge_(edge), cells_(flow.constants().grid.cells), counts_() {
    for (std::size_t d = 0; d < 3; ++d) counts_[d] = (cells_[d] + edge - 1) / edge;
}

int BlockSampler::extent(int direction, int block) const {
    return std::min(edge_, nth(cells_, direction) - block * edge_);
}

void BlockSampler::find(CellField criterion, double threshold) {
    const Slab slab = flow_.planes();
    const CellReader reader(flow_);
    const std::size_t components = to_index(entry_of(criterion).components);
    const int nx = counts_[0], ny = counts_[1], nz = counts_[2];
    std::vector<double> largest(to_index(nx) * to_index(ny) * to_index(nz), 0);
    const int layer = slab.first / edge_,
              layers = slab.count > 0 ? (slab.first + slab.count - 1) / edge_ - layer + 1 : 0;
    threads_.for_each(to_index(layers * ny), [&](std::size_t item, int) {
        const int bz = layer + static_cast<int>(item) / ny, by = static_cast<int>(item) % ny;
        double* const row = largest.data() + (static_cast<std::ptrdiff_t>(bz) * ny + by) * nx;
        std::vector<double> value(to_index(cells_[0]) * components);
        for (int k = std::max(bz * edge_, slab.first);
             k < std::min(bz * edge_ + extent(2, bz), slab.first + slab.count); ++k)
            for (int j = by * edge_; j < by * edge_ + extent(1, by); ++j) {
                reader.row(criterion, 0, j, k - slab.first, cells_[0], value.data());
                for (int i = 0; i < cells_[0]; ++i) {
                    const double* const v = value.data() + to_index(i) * components;
                    const double size =
                        components == 1 ? std::abs(v[0]) : std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
                    row[i / edge_] = std::max(row[i / edge_], size);
                }
            }
    });
    comm_.max(std::span(largest));
    blocks_.clear();
    for (int z = 0, at = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x, ++at)
                if (nth(largest, at) > threshold) blocks_.push_back({x, y, z});
}

std::vector<BlockSampler::Piece> BlockSampler::pieces(std::size_t most_numbers) const {
    const Slab slab = flow_.planes();
    std::vector<Piece> all;
    for (std::size_t first = 0; first < blocks_.size();) {
        const int z = blocks_[first][2];
        std::size_t last = first;
        while (last < blocks_.size() && blocks_[last][2] == z) ++last;
        // The rank with the last plane of the grid takes planes of blocks beyond it too.
        const int from = std::max(z * edge_, slab.first), end = slab.first + slab.count,
                  until = z == counts_[2] - 1 && end == cells_[2] ? (z + 1) * edge_ : std::min((z + 1) * edge_, end);
        if (until > from && slab.count > 0) {
            const std::size_t numbers = to_index(3 * edge_ * edge_) * to_index(until - from),
                              most = std::max<std::size_t>(1, most_numbers / numbers);
            for (std::size_t at = first; at < last; at += most)
                all.push_back({at, std::min(most, last - at), from - z * edge_, until - from});
        }
        first = last;
    }
    return all;
}

void BlockSampler::sample(CellField field, const Piece& piece, std::span<double> out) const {
    const CellReader reader(flow_);
    const std::size_t components = to_index(entry_of(field).components);
    const std::size_t row = to_index(edge_) * components;
    const std::size_t share = row * to_index(edge_ * piece.planes);
    std::fill(out.begin(), out.end(), std::numeric_limits<double>::quiet_NaN());
    threads_.for_each(piece.count, [&](std::size_t b, int) {
        const auto [x, y, z] = blocks_[piece.first + b];
        for (int p = 0; p < std::min(piece.planes, extent(2, z) - piece.plane); ++p)
            for (int j = 0; j < extent(1, y); ++j)
                reader.row(field, x * edge_, y * edge_ + j, z * edge_ + piece.plane + p - flow_.planes().first,
                           extent(0, x), out.data() + b * share + to_index(p * edge_ + j) * row);
    });
}

} // namespace skein
