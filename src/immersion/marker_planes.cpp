#include "immersion/marker_planes.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {

namespace {

constexpr int ghosts = FieldLayout::ghosts, none = -ghosts - 1;

int wrapped(int i, int n) { return (i % n + n) % n; }

/// Weights along a direction of the grid for the velocity `component`: point i is at i + 1/2, of the velocity across d at i + 1.
DeltaWeights weights_along(const FluidGrid& grid, DeltaKind delta, const Vec3d& place, int d, int component) {
    const double at = (component_of(place, d) - component_of(grid.lower, d)) / grid.h;
    return delta_weights(delta, at - (d == component ? 1.0 : 0.5));
}

} // namespace

MarkerPlanes::MarkerPlanes(const Communicator& comm, const Threads& threads, const FluidGrid& grid, DeltaKind delta, int across)
    : comm_(comm), threads_(threads), grid_(grid), delta_(delta), pencils_(grid, comm.rank(), comm.size(), across),
      layout_(pencils_.layout()), visits_(static_cast<std::size_t>(layout_.nz + 2 * ghosts)) {}

int MarkerPlanes::here(int cell, int direction, const Slab& own) const {
    const int n = grid_.cells[static_cast<std::size_t>(direction)];
    if (grid_.periodic(direction)) cell = wrapped(cell, n);
    const int place = cell - own.first;
    if (cell >= 0 && cell < n) return place >= 0 && place < own.count ? place : none;
    const bool mine = cell < 0 ? own.first == 0 : own.first + own.count == n;
    return mine && cell >= -ghosts && cell < n + ghosts ? place : none;
}

/// body(rank) for each rank whose cells a marker reaches, rising.
template <class Body> void MarkerPlanes::for_ranks_of(const Vec3d& place, Body&& body) const {
    if (comm_.size() == 1) {
        body(0);
        return;
    }
    int found[3 * width * width], count = 0;
    const auto inside = [&](int cell, int d) {
        const int n = grid_.cells[static_cast<std::size_t>(d)];
        return grid_.periodic(d) ? wrapped(cell, n) : std::clamp(cell, 0, n - 1);
    };
    for (int c = 0; c < 3; ++c) {
        const DeltaWeights y = weights_along(grid_, delta_, place, 1, c), z = weights_along(grid_, delta_, place, 2, c);
        const int rows = pencils_.across() > 1 ? y.count : 1;
        for (int k = z.first; k < z.first + z.count; ++k)
            for (int j = y.first; j < y.first + rows; ++j) found[count++] = pencils_.rank_of_cell(inside(j, 1), inside(k, 2));
    }
    std::sort(found, found + count);
    for (int i = 0; i < count; ++i)
        if (i == 0 || found[i] != found[i - 1]) body(found[i]);
}

void MarkerPlanes::settle(std::span<const Vec3d> places, std::span<const std::int64_t> identities) {
    const auto ranks = static_cast<std::size_t>(comm_.size());
    std::vector<std::vector<std::uint32_t>> to(ranks);
    for (std::uint32_t m = 0; m < places.size(); ++m)
        for_ranks_of(places[m], [&](int rank) { to[static_cast<std::size_t>(rank)].push_back(m); });
    sent_.clear(), sent_counts_.clear();
    for (const auto& markers : to) {
        sent_.insert(sent_.end(), markers.begin(), markers.end());
        sent_counts_.push_back(static_cast<std::int64_t>(markers.size()));
    }
    std::vector<Guest> guests;
    for (const std::uint32_t m : sent_) guests.push_back({places[m], identities[m]});
    std::vector<std::int64_t> arriving{sent_counts_};
    if (comm_.size() > 1) {
        const std::vector<std::byte> come =
            comm_.all_to_all(std::as_bytes(std::span(guests)), sizeof(Guest), sent_counts_, arriving);
        const auto* first = reinterpret_cast<const Guest*>(come.data());
        guests.assign(first, first + come.size() / sizeof(Guest));
    }
    arrival_.resize(guests.size());
    std::iota(arrival_.begin(), arrival_.end(), 0u);
    std::sort(arrival_.begin(), arrival_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return guests[a].identity < guests[b].identity; });
    footprints_.clear();
    for (auto& visits : visits_) visits.clear();
    sides_.assign(static_cast<std::size_t>(layout_.nz), 0);
    for (std::uint32_t m = 0; m < arrival_.size(); ++m) lay_out(guests[arrival_[m]].place, m);
    const auto any = [&](std::size_t first) {
        return std::any_of(visits_.begin() + static_cast<std::ptrdiff_t>(first),
                           visits_.begin() + static_cast<std::ptrdiff_t>(first + ghosts), [](const auto& v) { return !v.empty(); });
    };
    beyond_ = any(0) || any(static_cast<std::size_t>(layout_.nz + ghosts));
    make_messages(arriving);
}

void MarkerPlanes::lay_out(const Vec3d& place, std::uint32_t marker) {
    const Slab all{0, grid_.cells[0]};
    bool sideways = false;
    const auto axis = [&](const DeltaWeights& w, int d, const Slab& own, auto& index, auto& weight, auto& inside) {
        for (int i = 0; i < w.count; ++i) {
            const auto at = static_cast<std::size_t>(i);
            const int cell = here(w.first + i, d, own);
            index[at] = std::max(cell, -ghosts);
            weight[at] = cell == none ? 0 : w.weight[at];
            inside[at] = cell >= 0 && cell < own.count;
            sideways |= cell != none && !inside[at];
        }
    };
    for (int c = 0; c < 3; ++c) {
        Footprint f;
        const DeltaWeights x = weights_along(grid_, delta_, place, 0, c), y = weights_along(grid_, delta_, place, 1, c),
                           z = weights_along(grid_, delta_, place, 2, c);
        f.count = x.count, sideways = false;
        axis(x, 0, all, f.cell, f.along_x, f.inside_x), axis(y, 1, pencils_.rows(), f.row, f.along_y, f.inside_y);
        footprints_.push_back(f);
        for (int k = 0; k < z.count; ++k) {
            const int plane = here(z.first + k, 2, pencils_.planes());
            if (plane == none) continue;
            if (plane >= 0 && plane < layout_.nz && sideways) sides_[static_cast<std::size_t>(plane)] = 1;
            visits_[static_cast<std::size_t>(plane + ghosts)].push_back(
                {marker, static_cast<std::uint8_t>(c), static_cast<std::uint8_t>(k), z.weight[static_cast<std::size_t>(k)]});
        }
    }
}

/// `arriving`: numbers of markers that come from each rank.
void MarkerPlanes::make_messages(std::span<const std::int64_t> arriving) {
    const std::size_t shares_each = shares_of_marker();
    shares_back_.resize(shares_each * sent_.size()), changes_out_.resize(sent_.size());
    shares_.assign(shares_each * arrival_.size(), 0.0), changes_.resize(arrival_.size());
    if (comm_.size() == 1) return;
    std::vector<RepeatedMessages::Part> back, out, shares, changes;
    const auto add = [](std::vector<RepeatedMessages::Part>& parts, int rank, auto numbers) {
        if (!numbers.empty()) parts.push_back({rank, std::as_writable_bytes(numbers)});
    };
    std::size_t from = 0, at = 0;
    for (int r = 0; r < comm_.size(); ++r) {
        const auto sent = static_cast<std::size_t>(sent_counts_[static_cast<std::size_t>(r)]),
                   come = static_cast<std::size_t>(arriving[static_cast<std::size_t>(r)]);
        add(back, r, std::span(shares_back_).subspan(shares_each * from, shares_each * sent)),
            add(out, r, std::span(changes_out_).subspan(from, sent));
        add(shares, r, std::span(shares_).subspan(shares_each * at, shares_each * come)),
            add(changes, r, std::span(changes_).subspan(at, come));
        from += sent, at += come;
    }
    to_holders_ = RepeatedMessages(comm_, shares, back);
    to_planes_ = RepeatedMessages(comm_, out, changes);
}

void MarkerPlanes::interpolate(const ReadFields& fields, std::span<Vec3d> values) {
    const std::size_t rows = rows_of_plane(), numbers = shares_of_marker();
    threads_.for_each(visits_.size(), [&](std::size_t p, int) {
        const std::ptrdiff_t plane = layout_.at(0, 0, static_cast<int>(p) - ghosts);
        for (const Visit& visit : visits_[p]) {
            const Footprint& f = footprints_[3 * visit.marker + visit.component];
            const double* const from = fields[visit.component] + plane;
            double sum = 0, of_rows[width] = {};
            for (int j = 0; j < f.count; ++j) {
                const auto row = static_cast<std::size_t>(j);
                const double* const cells = from + f.row[row] * layout_.row;
                double of_row = 0;
                for (int i = 0; i < f.count; ++i) {
                    const auto cell = static_cast<std::size_t>(i);
                    of_row += f.along_x[cell] * cells[f.cell[cell]];
                }
                of_rows[j] = visit.along_z * f.along_y[row] * of_row;
                sum += of_rows[j];
            }
            double* const shares = &shares_[numbers * arrival_[visit.marker] + (visit.component * width + visit.place) * rows];
            if (rows == 1) *shares = sum;
            else std::copy_n(of_rows, width, shares);
        }
    });
    const bool alone = comm_.size() == 1;
    if (!alone) to_holders_.start(), to_holders_.finish();
    // Of rows and planes that a rank does not have its shares are 0.
    std::vector<double> whole(numbers * values.size(), 0.0);
    for (std::size_t i = 0; i < sent_.size(); ++i)
        for (std::size_t s = 0; s < numbers; ++s)
            whole[numbers * sent_[i] + s] += (alone ? shares_ : shares_back_)[numbers * i + s];
    for (std::size_t m = 0; m < values.size(); ++m) {
        const auto sum = [&](std::size_t c) {
            double of_plane[width] = {};
            for (std::size_t k = 0; k < width; ++k)
                for (std::size_t j = 0; j < rows; ++j) of_plane[k] += whole[numbers * m + (c * width + k) * rows + j];
            return (of_plane[0] + of_plane[1]) + (of_plane[2] + of_plane[3]);
        };
        values[m] = {sum(0), sum(1), sum(2)};
    }
}

void MarkerPlanes::spread(std::span<const Vec3d> changes, const Fields& fields) {
    const bool alone = comm_.size() == 1;
    std::vector<Vec3d>& sent = alone ? changes_ : changes_out_;
    for (std::size_t i = 0; i < sent_.size(); ++i) sent[i] = changes[sent_[i]];
    if (!alone) to_planes_.start(), to_planes_.finish();
    threads_.for_each(static_cast<std::size_t>(layout_.nz), [&](std::size_t p, int) {
        const std::ptrdiff_t plane = layout_.at(0, 0, static_cast<int>(p));
        for (const Visit& visit : visits_[p + ghosts]) {
            const Footprint& f = footprints_[3 * visit.marker + visit.component];
            double* const to = fields[visit.component] + plane;
            const double change = component_of(changes_[arrival_[visit.marker]], visit.component) * visit.along_z;
            for (int j = 0; j < f.count; ++j) {
                const auto row = static_cast<std::size_t>(j);
                if (!f.inside_y[row]) continue;
                double* const cells = to + f.row[row] * layout_.row;
                const double of_row = change * f.along_y[row];
                for (int i = 0; i < f.count; ++i) {
                    const auto cell = static_cast<std::size_t>(i);
                    if (f.inside_x[cell]) cells[f.cell[cell]] += of_row * f.along_x[cell];
                }
            }
        }
    });
}

void MarkerPlanes::clear(const Fields& fields) const {
    threads_.for_each(visits_.size(), [&](std::size_t p, int) {
        const std::ptrdiff_t plane = layout_.at(0, 0, static_cast<int>(p) - ghosts);
        for (const Visit& visit : visits_[p]) {
            const Footprint& f = footprints_[3 * visit.marker + visit.component];
            for (int j = 0; j < f.count; ++j)
                for (int i = 0; i < f.count; ++i)
                    fields[visit.component]
                          [plane + f.row[static_cast<std::size_t>(j)] * layout_.row + f.cell[static_cast<std::size_t>(i)]] = 0;
        }
    });
}

} // namespace skein
