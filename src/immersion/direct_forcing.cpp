#include "immersion/direct_forcing.hpp"

#include "parallel/exact_sum.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

constexpr int reach = 2; ///< planes beyond that of a marker which it may reach

double component_of(const Vec3d& v, int c) { return c == 0 ? v.x : c == 1 ? v.y : v.z; }
double& component_of(Vec3d& v, int c) { return c == 0 ? v.x : c == 1 ? v.y : v.z; }

int wrapped(int i, int n) { return (i % n + n) % n; }

} // namespace

DirectForcing::DirectForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid, const ForcingNumbers& numbers,
                             std::function<void(double time, Markers& markers)> place, bool moves)
    : comm_(comm), threads_(threads), grid_(grid), numbers_(numbers), slab_(slab_of(grid.cells[2], comm.rank(), comm.size())),
      layout_(grid.cells[0], grid.cells[1], slab_.count), place_(std::move(place)), moves_(moves) {}

int DirectForcing::plane_of(std::uint32_t marker) const {
    const int n = grid_.cells[2], plane = static_cast<int>(std::floor((markers_.place[marker].z - grid_.lower.z) / grid_.h));
    return grid_.periodic(2) ? wrapped(plane, n) : std::clamp(plane, 0, n - 1);
}

bool DirectForcing::reaches(std::uint32_t marker, int rank) const {
    const Slab planes = slab_of(grid_.cells[2], rank, comm_.size());
    for (int k = plane_of(marker) - reach; k <= plane_of(marker) + reach; ++k) {
        const int at = grid_.periodic(2) ? wrapped(k, grid_.cells[2]) : k;
        if (at >= planes.first && at < planes.first + planes.count) return true;
    }
    return false;
}

DirectForcing::Support DirectForcing::support(std::uint32_t marker, int component) const {
    const Vec3d at = (1 / grid_.h) * (markers_.place[marker] - grid_.lower);
    Support s;
    for (int d = 0; d < 3; ++d) // point i is at i + 1/2, of the velocity across d at i + 1
        s[static_cast<std::size_t>(d)] = delta_weights(numbers_.delta, component_of(at, d) - (d == component ? 1.0 : 0.5));
    return s;
}

/// Markers where they are now: whose they are, which planes they reach, and their weights.
void DirectForcing::settle(const FlowStage& stage) {
    place_(stage.time, markers_);
    const auto count = static_cast<std::uint32_t>(markers_.count());
    own_.clear(), come_.clear();
    near_.assign(static_cast<std::size_t>(slab_.count), {});
    shared_.assign(static_cast<std::size_t>(comm_.size()), {});
    std::vector<std::vector<std::uint32_t>> from(static_cast<std::size_t>(comm_.size()));
    for (std::uint32_t m = 0; m < count; ++m) {
        const int owner = rank_of_plane(plane_of(m), grid_.cells[2], comm_.size());
        if (owner == comm_.rank()) {
            own_.push_back(m);
            for (int r = 0; r < comm_.size(); ++r)
                if (r != owner && reaches(m, r)) shared_[static_cast<std::size_t>(r)].push_back(m);
        } else if (reaches(m, comm_.rank())) {
            from[static_cast<std::size_t>(owner)].push_back(m);
        } else {
            continue;
        }
        for (int k = 0; k < slab_.count; ++k) {
            const int apart = std::abs(slab_.first + k - plane_of(m)), n = grid_.cells[2];
            if (apart <= reach || (grid_.periodic(2) && n - apart <= reach)) near_[static_cast<std::size_t>(k)].push_back(m);
        }
    }
    for (const auto& markers : from) come_.insert(come_.end(), markers.begin(), markers.end());
    change_.resize(count), weight_.resize(count);
    given_.resize(markers_.first.size() - 1, Vec3d{0, 0, 0});
    // Weights by what a change of 1 at all markers does at each.
    for (const auto& markers : near_)
        for (const std::uint32_t m : markers) change_[m] = {1, 1, 1};
    for (double* field : stage.scratch) std::fill_n(field, layout_.size(), 0.0);
    spread(stage.scratch);
    stage.fill_ghost_planes(stage.scratch);
    threads_.for_each(own_.size(), [&](std::size_t i, int) {
        for (int c = 0; c < 3; ++c)
            component_of(weight_[own_[i]], c) = 1 / interpolated(stage.scratch[static_cast<std::size_t>(c)], own_[i], c);
    });
    settled_ = true;
}

double DirectForcing::interpolated(const double* field, std::uint32_t marker, int component) const {
    const auto [x, y, z] = support(marker, component);
    double sum = 0;
    for (int k = 0; k < z.count; ++k) {
        // The nearest image of the plane: a marker's own lies here, so that all are here or ghosts.
        int plane = z.first + k - slab_.first;
        if (grid_.periodic(2)) {
            const int n = grid_.cells[2];
            while (plane < -FieldLayout::ghosts) plane += n;
            while (plane >= slab_.count + FieldLayout::ghosts) plane -= n;
        }
        double of_plane = 0;
        for (int j = 0; j < y.count; ++j) {
            const int row = grid_.periodic(1) ? wrapped(y.first + j, layout_.ny) : y.first + j;
            double of_row = 0;
            for (int i = 0; i < x.count; ++i) {
                const int cell = grid_.periodic(0) ? wrapped(x.first + i, layout_.nx) : x.first + i;
                of_row += x.weight[static_cast<std::size_t>(i)] * field[layout_.at(cell, row, plane)];
            }
            of_plane += y.weight[static_cast<std::size_t>(j)] * of_row;
        }
        sum += z.weight[static_cast<std::size_t>(k)] * of_plane;
    }
    return sum;
}

void DirectForcing::spread(const std::array<double*, 3>& fields) const {
    const int n = grid_.cells[2];
    threads_.for_each(static_cast<std::size_t>(slab_.count), [&](std::size_t p, int) {
        const int here = slab_.first + static_cast<int>(p);
        for (const std::uint32_t m : near_[p])
            for (int c = 0; c < 3; ++c) {
                const auto [x, y, z] = support(m, c);
                for (int k = 0; k < z.count; ++k) {
                    const int plane = grid_.periodic(2) ? wrapped(z.first + k, n) : z.first + k;
                    if (plane != here) continue;
                    const double change = component_of(change_[m], c) * z.weight[static_cast<std::size_t>(k)];
                    for (int j = 0; j < y.count; ++j) {
                        const int row = grid_.periodic(1) ? wrapped(y.first + j, layout_.ny) : y.first + j;
                        if (row < 0 || row >= layout_.ny) continue;
                        const double of_row = change * y.weight[static_cast<std::size_t>(j)];
                        for (int i = 0; i < x.count; ++i) {
                            const int cell = grid_.periodic(0) ? wrapped(x.first + i, layout_.nx) : x.first + i;
                            if (cell < 0 || cell >= layout_.nx) continue;
                            fields[static_cast<std::size_t>(c)][layout_.at(cell, row, static_cast<int>(p))] +=
                                of_row * x.weight[static_cast<std::size_t>(i)];
                        }
                    }
                }
            }
    });
}

void DirectForcing::share() {
    if (comm_.size() == 1) return;
    std::vector<Vec3d> sent;
    std::vector<std::int64_t> counts, received;
    for (const auto& markers : shared_) {
        for (const std::uint32_t m : markers) sent.push_back(change_[m]);
        counts.push_back(static_cast<std::int64_t>(markers.size()));
    }
    const std::vector<std::byte> come = comm_.all_to_all(std::as_bytes(std::span(sent)), sizeof(Vec3d), counts, received);
    const auto* changes = reinterpret_cast<const Vec3d*>(come.data());
    for (std::size_t i = 0; i < come_.size(); ++i) change_[come_[i]] = changes[i];
}

void DirectForcing::add_given(const std::vector<Vec3d>& changes) {
    const double volume = grid_.h * grid_.h * grid_.h;
    std::vector<std::vector<double>> terms(3 * given_.size());
    std::size_t body = 0;
    for (std::size_t i = 0; i < own_.size(); ++i) {
        while (own_[i] >= markers_.first[body + 1]) ++body;
        for (int c = 0; c < 3; ++c) terms[3 * body + static_cast<std::size_t>(c)].push_back(volume * component_of(changes[i], c));
    }
    const std::vector<double> sums = exact_sums(comm_, terms);
    for (std::size_t b = 0; b < given_.size(); ++b) given_[b] += Vec3d{sums[3 * b], sums[3 * b + 1], sums[3 * b + 2]};
}

void DirectForcing::apply(const FlowStage& stage) {
    if (!settled_ || moves_) settle(stage);
    std::vector<Vec3d> difference(own_.size()), changes(own_.size(), Vec3d{0, 0, 0});
    for (int sweep = 0;; ++sweep) {
        stage.fill_ghost_planes(stage.velocity);
        threads_.for_each(own_.size(), [&](std::size_t i, int) {
            for (int c = 0; c < 3; ++c)
                component_of(difference[i], c) = component_of(markers_.velocity[own_[i]], c) -
                                                 interpolated(stage.velocity[static_cast<std::size_t>(c)], own_[i], c);
        });
        double slip = 0;
        for (const Vec3d& d : difference) slip = std::max(slip, norm(d));
        slip_ = comm_.max(slip);
        if (sweep == numbers_.sweeps || slip_ < numbers_.slip) break;
        for (std::size_t i = 0; i < own_.size(); ++i) {
            const Vec3d &w = weight_[own_[i]], &d = difference[i];
            change_[own_[i]] = {w.x * d.x, w.y * d.y, w.z * d.z};
            changes[i] += change_[own_[i]];
        }
        share();
        spread(stage.velocity);
    }
    add_given(changes);
}

} // namespace skein
