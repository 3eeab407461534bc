#include "simulation/migration.hpp"

#include "skein/core/index.hpp"
#include "tiles/clusters.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <tuple>

namespace skein {

namespace {

static_assert(alignof(Slot<1>) <= alignof(double), "states are looked at where they arrived");

std::size_t doubles_for(std::size_t bytes) { return (bytes + sizeof(double) - 1) / sizeof(double); }

std::uint64_t key_of(const double* record) { return std::bit_cast<std::uint64_t>(record[0]); }
std::int64_t gid_of(const double* record) { return static_cast<std::int64_t>(record[1]); }

} // namespace

std::int64_t Migration::count(const Communicator& comm, std::span<const Assignment> assigned) {
    return comm.sum(
        std::count_if(assigned.begin(), assigned.end(), [&](const Assignment& a) { return a.rank != comm.rank(); }));
}

std::vector<Migration::Layout> Migration::layouts(const Communicator& comm, std::span<const RodGroup> groups,
                                                  const Rods& rods) const {
    std::vector<double> most; // of a rank: numbers that passes remember; not 0 where it lacks places
    for (const RodGroup& group : groups) most.insert(most.end(), {0.0, group.places().holds_all() ? 0.0 : 1.0});
    const auto local = rods.local();
    for (std::size_t i = 0; i < local.size(); ++i)
        if (i == 0 || local[i - 1].group != local[i].group)
            most[2 * static_cast<std::size_t>(local[i].group)] = static_cast<double>(rods.memory(i).size());
    comm.max(most);
    std::vector<Layout> layouts;
    for (std::size_t g = 0; g < groups.size(); ++g)
        layouts.push_back({static_cast<std::size_t>(groups[g].slots()) * slot_doubles,
                           static_cast<std::size_t>(most[2 * g]),
                           most[2 * g + 1] > 0 ? doubles_for(groups[g].places().record_bytes()) : 0});
    return layouts;
}

Migration::Migration(const Communicator& comm, std::span<RodGroup> groups, const Rods& rods,
                     std::span<const Assignment> assigned, int lanes, int threads)
    : layout_(layouts(comm, groups, rods)) {
    for (const RodGroup& group : groups) first_gid_.push_back(group.first_gid());
    const auto local = rods.local();
    std::vector<std::int64_t> send_counts(static_cast<std::size_t>(comm.size()), 0), receive_counts;
    std::size_t staying = 0;
    for (std::size_t i = 0; i < local.size(); ++i) {
        const std::size_t length = nth(layout_, local[i].group).length();
        if (assigned[i].rank == comm.rank()) staying += length;
        else nth(send_counts, assigned[i].rank) += static_cast<std::int64_t>(length);
    }
    stay_.resize(staying);
    std::vector<std::int64_t> next(send_counts.size(), 0); // number of a rank's records
    std::partial_sum(send_counts.begin(), send_counts.end() - 1, next.begin() + 1);
    std::vector<double> leave(static_cast<std::size_t>(next.back() + send_counts.back()));
    std::vector<double*> record;
    double* stays = stay_.data();
    for (std::size_t i = 0; i < local.size(); ++i) {
        const std::size_t length = nth(layout_, local[i].group).length();
        std::int64_t& at = nth(next, assigned[i].rank);
        if (assigned[i].rank == comm.rank()) record.push_back(std::exchange(stays, stays + length));
        else record.push_back(leave.data() + std::exchange(at, at + static_cast<std::int64_t>(length)));
    }

    std::vector<std::vector<std::int64_t>> held;
    std::vector<std::vector<std::byte>> places;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const bool travel = layout_[g].places > 0;
        held.push_back(travel ? groups[g].places().held() : std::vector<std::int64_t>());
        places.push_back(travel ? groups[g].places().records() : std::vector<std::byte>());
    }
    std::vector<std::size_t> all(local.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    rods.read(all, Copy::canonical, 0, [&](int, std::size_t i, const RodCopy& rod) {
        const auto g = static_cast<std::size_t>(local[i].group);
        const Layout& layout = layout_[g];
        double* out = record[i];
        *out++ = std::bit_cast<double>(assigned[i].key);
        *out++ = static_cast<double>(local[i].gid);
        std::memcpy(out, rod.state.data(), layout.state * sizeof(double));
        out += layout.state;
        const RodBudget b = rods.budget(i);
        for (const double energy : {b.loads, b.walls, b.dissipated, b.held_before}) *out++ = energy;
        const std::vector<double> remembered = rods.memory(i);
        out = std::copy(remembered.begin(), remembered.end(), out);
        if (layout.places == 0) return;
        const auto row = static_cast<std::size_t>(std::lower_bound(held[g].begin(), held[g].end(), local[i].index) -
                                                  held[g].begin());
        const std::size_t bytes = groups[g].places().record_bytes();
        std::memcpy(out, &places[g][row * bytes], bytes);
    });
    const auto bytes = comm.all_to_all(std::as_bytes(std::span(leave)), sizeof(double), send_counts, receive_counts);
    leave = {};
    come_.resize(bytes.size() / sizeof(double));
    if (!come_.empty()) std::memcpy(come_.data(), bytes.data(), bytes.size());
    find_owned(groups, lanes, threads);
    keep_places(groups);
}

void Migration::find_owned(std::span<const RodGroup> groups, int lanes, int threads) {
    struct Found {
        int group;
        const double* record;
    };
    std::vector<Found> found;
    for (const std::vector<double>* from : {&stay_, &come_})
        for (std::size_t at = 0; at < from->size();) {
            const double* record = from->data() + at;
            const auto behind = std::upper_bound(first_gid_.begin(), first_gid_.end(), gid_of(record));
            found.push_back({static_cast<int>(behind - first_gid_.begin()) - 1, record});
            at += nth(layout_, found.back().group).length();
        }
    std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
        return std::tuple(a.group, key_of(a.record), gid_of(a.record)) <
               std::tuple(b.group, key_of(b.record), gid_of(b.record));
    });
    std::vector<LocalRod> along_curve;
    for (const auto& [group, record] : found)
        along_curve.push_back({gid_of(record), group, gid_of(record) - nth(first_gid_, group)});
    for (const std::size_t i : order_of_tiles(groups, along_curve, lanes, threads)) {
        owned_.push_back(along_curve[i]);
        record_.push_back(found[i].record);
    }
}

void Migration::keep_places(std::span<RodGroup> groups) const {
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (layout_[g].places == 0) continue;
        Places& places = groups[g].places();
        std::vector<std::int64_t> indices;
        std::vector<std::byte> records;
        for (std::size_t i = 0; i < owned_.size(); ++i) {
            if (owned_[i].group != static_cast<int>(g)) continue;
            indices.push_back(owned_[i].index);
            const auto* own = reinterpret_cast<const std::byte*>(record_[i] + layout_[g].length() - layout_[g].places);
            records.insert(records.end(), own, own + places.record_bytes());
        }
        places.keep(indices, records);
    }
}

std::span<const Slot<1>> Migration::state(std::size_t i) const {
    return {reinterpret_cast<const Slot<1>*>(record_[i] + Layout::head),
            nth(layout_, owned_[i].group).state / slot_doubles};
}

void Migration::put_into(Rods& rods) const {
    for (std::size_t i = 0; i < owned_.size(); ++i) { // one by one: rods of a tile share what is put there
        const Layout& layout = nth(layout_, owned_[i].group);
        const double* behind = record_[i] + Layout::head + layout.state;
        rods.import_rod(i, state(i));
        rods.set_budget(i, {behind[0], behind[1], behind[2], behind[3]});
        if (layout.memory > 0) rods.set_memory(i, {behind + Layout::budget, layout.memory});
    }
}

} // namespace skein
