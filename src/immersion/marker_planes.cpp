#include "immersion/marker_planes.hpp"

#include "parallel/blocks.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <type_traits>

namespace skein {

namespace {

constexpr int ghosts = FieldLayout::ghosts, none = -ghosts - 1;

int wrapped(int i, int n) { return (i % n + n) % n; }

/// Weights along a direction of the grid. Point i is at i + 1/2, and at i + 1 for the velocity along that direction.
struct WeightsAlong {
    DeltaWeights of_middles, of_faces;
    const DeltaWeights& of(bool face) const { return face ? of_faces : of_middles; }
};

WeightsAlong weights_along(const FluidGrid& grid, DeltaKind delta, const Vec3d& place, int d) {
    const double at = (component_of(place, d) - component_of(grid.lower, d)) / grid.h;
    return {delta_weights(delta, at - 0.5), delta_weights(delta, at - 1.0)};
}

} // namespace

MarkerPlanes::MarkerPlanes(const Communicator& comm, const Threads& threads, const FluidGrid& grid, DeltaKind delta,
                           int across)
    : comm_(comm), threads_(threads), grid_(grid), delta_(delta), pencils_(grid, comm.rank(), comm.size(), across),
      layout_(pencils_.layout()), visits_(to_index(layout_.nz + 2 * ghosts)) {}

int MarkerPlanes::here(int cell, int direction, const Slab& own) const {
    const int n = nth(grid_.cells, direction);
    if (grid_.periodic(direction)) cell = wrapped(cell, n);
    const int place = cell - own.first;
    if (cell >= 0 && cell < n) return place >= 0 && place < own.count ? place : none;
    const bool mine = cell < 0 ? own.first == 0 : own.first + own.count == n;
    return mine && cell >= -ghosts && cell < n + ghosts ? place : none;
}

/// Calls body(rank) for each rank whose cells a marker reaches, in rising order.
template <class Body> void MarkerPlanes::for_ranks_of(const Vec3d& place, Body&& body) const {
    int found[3 * width * width], count = 0;
    const auto inside = [&](int cell, int d) {
        const int n = nth(grid_.cells, d);
        return grid_.periodic(d) ? wrapped(cell, n) : std::clamp(cell, 0, n - 1);
    };
    const WeightsAlong along_y = weights_along(grid_, delta_, place, 1),
                       along_z = weights_along(grid_, delta_, place, 2);
    for (int c = 0; c < 3; ++c) {
        const DeltaWeights &y = along_y.of(c == 1), &z = along_z.of(c == 2);
        const int rows = pencils_.across() > 1 ? y.count : 1;
        for (int k = z.first; k < z.first + z.count; ++k)
            for (int j = y.first; j < y.first + rows; ++j)
                found[count++] = pencils_.rank_of_cell(inside(j, 1), inside(k, 2));
    }
    std::sort(found, found + count);
    for (int i = 0; i < count; ++i)
        if (i == 0 || found[i] != found[i - 1]) body(found[i]);
}

/// Lists the markers that each rank needs.
void MarkerPlanes::send_to_planes(std::span<const Vec3d> places) {
    sent_counts_.assign(to_index(comm_.size()), 0);
    if (comm_.size() == 1) { // all markers in order
        sent_.resize(places.size());
        std::iota(sent_.begin(), sent_.end(), 0u);
        sent_counts_[0] = static_cast<std::int64_t>(places.size());
        return;
    }
    std::vector<std::vector<std::uint32_t>> to(sent_counts_.size());
    for (std::uint32_t m = 0; m < places.size(); ++m)
        for_ranks_of(places[m], [&](int rank) { nth(to, rank).push_back(m); });
    sent_.clear();
    for (std::size_t rank = 0; rank < to.size(); ++rank) {
        sent_.insert(sent_.end(), to[rank].begin(), to[rank].end());
        sent_counts_[rank] = static_cast<std::int64_t>(to[rank].size());
    }
}

void MarkerPlanes::settle(std::span<const Vec3d> places, std::span<const std::int64_t> identities) {
    send_to_planes(places);
    std::vector<Guest> guests(sent_.size());
    for_blocks(threads_, guests.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t i = begin; i < end; ++i) guests[i] = {places[sent_[i]], identities[sent_[i]]};
    });
    std::vector<std::int64_t> arriving{sent_counts_};
    if (comm_.size() > 1) {
        const std::vector<std::byte> come =
            comm_.all_to_all(std::as_bytes(std::span(guests)), sizeof(Guest), sent_counts_, arriving);
        const auto* first = reinterpret_cast<const Guest*>(come.data());
        guests.assign(first, first + come.size() / sizeof(Guest));
    }
    order_arrivals(guests);
    footprints_.resize(3 * arrival_.size());
    for_blocks(threads_, arrival_.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t m = begin; m < end; ++m) lay_out(guests[arrival_[m]].place, &footprints_[3 * m]);
    });
    visit_planes();
    make_messages(arriving);
}

/// Orders markers by identity, unless the same markers arrive in the same order as before.
void MarkerPlanes::order_arrivals(std::span<const Guest> guests) {
    const auto same = [](const Guest& guest, std::int64_t identity) { return guest.identity == identity; };
    if (std::ranges::equal(guests, arrived_, same)) return;
    arrived_.clear();
    for (const Guest& guest : guests) arrived_.push_back(guest.identity);
    arrival_.resize(guests.size());
    std::iota(arrival_.begin(), arrival_.end(), 0u);
    std::sort(arrival_.begin(), arrival_.end(),
              [this](std::uint32_t a, std::uint32_t b) { return arrived_[a] < arrived_[b]; });
}

/// Lists the markers of each plane, in the order of identities.
void MarkerPlanes::visit_planes() {
    for (auto& visits : visits_) visits.clear();
    sides_.assign(to_index(layout_.nz), 0);
    for (std::uint32_t m = 0; m < arrival_.size(); ++m)
        for (std::uint8_t c = 0; c < 3; ++c) {
            const Footprint& f = footprints_[3 * m + c];
            for (std::uint8_t place = 0; place < width; ++place) {
                const int plane = f.plane[place];
                if (plane == none) continue;
                if (f.beyond_sides && plane >= 0 && plane < layout_.nz) nth(sides_, plane) = 1;
                nth(visits_, plane + ghosts).push_back({m, c, place});
            }
        }
    const auto any = [&](int first) {
        return std::any_of(visits_.begin() + first, visits_.begin() + first + ghosts,
                           [](const auto& v) { return !v.empty(); });
    };
    beyond_ = any(0) || any(layout_.nz + ghosts);
}

void MarkerPlanes::lay_out(const Vec3d& place, Footprint* of_components) const {
    const WeightsAlong along[3] = {weights_along(grid_, delta_, place, 0), weights_along(grid_, delta_, place, 1),
                                   weights_along(grid_, delta_, place, 2)};
    const Slab all{0, grid_.cells[0]};
    for (int c = 0; c < 3; ++c) {
        Footprint& f = of_components[c];
        f.run = true;
        f.beyond_sides = false;
        const auto axis = [&](int d, const Slab& own, auto& index, auto& weight, auto& inside) {
            const DeltaWeights& w = along[d].of(c == d);
            for (int i = 0; i < w.count; ++i) {
                const std::size_t at = to_index(i);
                const int cell = here(w.first + i, d, own);
                index[at] = std::max(cell, -ghosts);
                weight[at] = cell == none ? 0 : w.weight[at];
                inside[at] = cell >= 0 && cell < own.count;
                f.beyond_sides |= cell != none && !inside[at];
                f.run &= d == 1 || (inside[at] && (i == 0 || index[at] == index[at - 1] + 1));
            }
        };
        axis(0, all, f.cell, f.along_x, f.inside_x);
        axis(1, pencils_.rows(), f.row, f.along_y, f.inside_y);
        const DeltaWeights& z = along[2].of(c == 2);
        f.along_z = z.weight;
        f.plane.fill(none);
        for (int k = 0; k < z.count; ++k) nth(f.plane, k) = here(z.first + k, 2, pencils_.planes());
    }
}

/// `arriving` counts markers from each rank.
void MarkerPlanes::make_messages(std::span<const std::int64_t> arriving) {
    const std::size_t shares_each = shares_of_marker();
    shares_back_.resize(shares_each * sent_.size());
    changes_out_.resize(sent_.size());
    shares_.assign(shares_each * arrival_.size(), 0.0);
    changes_.resize(arrival_.size());
    if (comm_.size() == 1) return;
    std::vector<RepeatedMessages::Part> back, out, shares, changes;
    const auto add = [](std::vector<RepeatedMessages::Part>& parts, int rank, auto numbers) {
        if (!numbers.empty()) parts.push_back({rank, std::as_writable_bytes(numbers)});
    };
    std::size_t from = 0, at = 0;
    for (int r = 0; r < comm_.size(); ++r) {
        const std::size_t sent = to_index(nth(sent_counts_, r)), come = to_index(nth(arriving, r));
        add(back, r, std::span(shares_back_).subspan(shares_each * from, shares_each * sent));
        add(out, r, std::span(changes_out_).subspan(from, sent));
        add(shares, r, std::span(shares_).subspan(shares_each * at, shares_each * come));
        add(changes, r, std::span(changes_).subspan(at, come));
        from += sent;
        at += come;
    }
    to_holders_ = RepeatedMessages(comm_, shares, back);
    to_planes_ = RepeatedMessages(comm_, out, changes);
}

template <class Body> void MarkerPlanes::with_points(Body&& body) const {
    if (delta_ == DeltaKind::three_point) body(std::integral_constant<int, 3>{});
    else body(std::integral_constant<int, 4>{});
}

template <int points> void MarkerPlanes::sum_footprint(const Visit& visit, const double* plane) {
    const Footprint& f = footprint(visit);
    const double along_z = f.along_z[visit.place];
    double sum = 0, of_rows[width] = {};
    for (std::size_t j = 0; j < points; ++j) {
        const double* const cells = plane + f.row[j] * layout_.row;
        double of_row = 0;
        if (f.run) {
            const double* const run = cells + f.cell[0];
            for (std::size_t i = 0; i < points; ++i) of_row += f.along_x[i] * run[i];
        } else {
            for (std::size_t i = 0; i < points; ++i) of_row += f.along_x[i] * cells[f.cell[i]];
        }
        of_rows[j] = along_z * f.along_y[j] * of_row;
        sum += of_rows[j];
    }
    const std::size_t rows = rows_of_plane();
    double* const shares = &shares_[shares_of_marker() * arrival_[visit.marker] +
                                    (visit.component * std::size_t{width} + visit.place) * rows];
    if (rows == 1) *shares = sum;
    else std::copy_n(of_rows, width, shares);
}

void MarkerPlanes::interpolate(const ReadFields& fields, std::span<Vec3d> values) {
    with_points([&](auto points) {
        threads_.for_each(visits_.size(), [&](std::size_t p, int) {
            const std::ptrdiff_t plane = layout_.at(0, 0, static_cast<int>(p) - ghosts);
            for (const Visit& visit : visits_[p]) sum_footprint<points>(visit, fields[visit.component] + plane);
        });
    });
    add_shares(values);
}

void MarkerPlanes::add_shares(std::span<Vec3d> values) {
    const std::size_t rows = rows_of_plane(), numbers = shares_of_marker();
    const bool alone = comm_.size() == 1; // markers arrive in order at the only rank
    if (!alone) {
        to_holders_.start();
        to_holders_.finish();
        // Shares of a rank are 0 for rows and planes of other ranks.
        whole_.assign(numbers * values.size(), 0.0);
        for (std::size_t i = 0; i < sent_.size(); ++i)
            for (std::size_t s = 0; s < numbers; ++s) whole_[numbers * sent_[i] + s] += shares_back_[numbers * i + s];
    }
    const std::vector<double>& whole = alone ? shares_ : whole_;
    for_blocks(threads_, values.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t m = begin; m < end; ++m) {
            const auto sum = [&](std::size_t c) {
                double of_plane[width] = {};
                for (std::size_t k = 0; k < width; ++k)
                    for (std::size_t j = 0; j < rows; ++j)
                        of_plane[k] += whole[numbers * m + (c * width + k) * rows + j];
                return (of_plane[0] + of_plane[1]) + (of_plane[2] + of_plane[3]);
            };
            values[m] = {sum(0), sum(1), sum(2)};
        }
    });
}

template <int points> void MarkerPlanes::add_footprint(const Visit& visit, double change, double* plane) const {
    const Footprint& f = footprint(visit);
    change *= f.along_z[visit.place];
    for (std::size_t j = 0; j < points; ++j) {
        if (!f.inside_y[j]) continue;
        double* const cells = plane + f.row[j] * layout_.row;
        const double of_row = change * f.along_y[j];
        if (f.run) {
            double* const run = cells + f.cell[0];
            for (std::size_t i = 0; i < points; ++i) run[i] += of_row * f.along_x[i];
        } else {
            for (std::size_t i = 0; i < points; ++i)
                if (f.inside_x[i]) cells[f.cell[i]] += of_row * f.along_x[i];
        }
    }
}

void MarkerPlanes::spread(std::span<const Vec3d> changes, const Fields& fields) {
    const bool alone = comm_.size() == 1;
    std::vector<Vec3d>& sent = alone ? changes_ : changes_out_;
    for (std::size_t i = 0; i < sent_.size(); ++i) sent[i] = changes[sent_[i]];
    if (!alone) {
        to_planes_.start();
        to_planes_.finish();
    }
    with_points([&](auto points) {
        threads_.for_each(to_index(layout_.nz), [&](std::size_t p, int) {
            const std::ptrdiff_t plane = layout_.at(0, 0, static_cast<int>(p));
            for (const Visit& visit : visits_[p + ghosts])
                add_footprint<points>(visit, component_of(changes_[arrival_[visit.marker]], visit.component),
                                      fields[visit.component] + plane);
        });
    });
}

template <int points> void MarkerPlanes::clear_footprint(const Visit& visit, double* plane) const {
    const Footprint& f = footprint(visit);
    for (std::size_t j = 0; j < points; ++j)
        for (std::size_t i = 0; i < points; ++i) plane[f.row[j] * layout_.row + f.cell[i]] = 0;
}

void MarkerPlanes::respond_to_ones(const Fields& fields, std::span<Vec3d> values) {
    with_points([&](auto points) {
        threads_.for_each(visits_.size(), [&](std::size_t p, int) {
            const int k = static_cast<int>(p) - ghosts;
            const auto plane_of = [&](const Visit& visit) { return fields[visit.component] + layout_.at(0, 0, k); };
            for (const Visit& visit : visits_[p]) clear_footprint<points>(visit, plane_of(visit));
            if (k >= 0 && k < layout_.nz)
                for (const Visit& visit : visits_[p]) add_footprint<points>(visit, 1, plane_of(visit));
            for (const Visit& visit : visits_[p]) sum_footprint<points>(visit, plane_of(visit));
        });
    });
    add_shares(values);
}

} // namespace skein
