#include "simulation/migration.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <tuple>

namespace skein {

namespace {

/// Records of equal length, in any order, to a rank each. Collective.
template <class T>
std::vector<T> sent_to(const Communicator& comm, std::span<const T> records, std::size_t length, std::span<const int> ranks) {
    std::vector<std::size_t> order(ranks.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return ranks[a] < ranks[b]; });
    std::vector<std::int64_t> send_counts(static_cast<std::size_t>(comm.size()), 0), receive_counts;
    std::vector<T> sorted;
    sorted.reserve(records.size());
    for (const std::size_t i : order) {
        ++send_counts[static_cast<std::size_t>(ranks[i])];
        const auto record = records.subspan(i * length, length);
        sorted.insert(sorted.end(), record.begin(), record.end());
    }
    const auto bytes = comm.all_to_all(std::as_bytes(std::span<const T>(sorted)), length * sizeof(T), send_counts, receive_counts);
    std::vector<T> arrived(bytes.size() / sizeof(T));
    if (!arrived.empty()) std::memcpy(arrived.data(), bytes.data(), bytes.size());
    return arrived;
}

/// What places know of the rods of a group, to the ranks that are to own them: all keep their own. Collective.
void move_places(const Communicator& comm, Places& places, std::span<const std::int64_t> indices, std::span<const int> ranks,
                 std::span<const std::int64_t> kept) {
    if (comm.min(static_cast<std::int64_t>(places.holds_all())) != 0) return;
    const std::vector<std::int64_t> held = places.held();
    const std::vector<std::byte> records = places.records();
    const std::size_t length = sizeof(std::int64_t) + places.record_bytes();
    std::vector<std::byte> numbered(indices.size() * length);
    for (std::size_t i = 0; i < indices.size(); ++i) {
        const auto row = static_cast<std::size_t>(std::lower_bound(held.begin(), held.end(), indices[i]) - held.begin());
        std::memcpy(&numbered[i * length], &indices[i], sizeof(std::int64_t));
        std::memcpy(&numbered[i * length + sizeof(std::int64_t)], &records[row * places.record_bytes()], places.record_bytes());
    }
    const std::vector<std::byte> arrived = sent_to<std::byte>(comm, numbered, length, ranks);
    std::vector<std::pair<std::int64_t, std::size_t>> found;
    for (std::size_t at = 0; at < arrived.size(); at += length) {
        std::int64_t index;
        std::memcpy(&index, &arrived[at], sizeof index);
        found.emplace_back(index, at + sizeof index);
    }
    std::sort(found.begin(), found.end());
    std::vector<std::byte> own;
    for (const std::int64_t index : kept) {
        const auto at = std::lower_bound(found.begin(), found.end(), std::pair(index, std::size_t{0}))->second;
        own.insert(own.end(), arrived.begin() + static_cast<std::ptrdiff_t>(at),
                   arrived.begin() + static_cast<std::ptrdiff_t>(at + places.record_bytes()));
    }
    places.keep(kept, own);
}

} // namespace

Migration::Migration(const Communicator& comm, std::span<RodGroup> groups, const Rods& rods, std::span<const Assignment> assigned)
    : groups_(groups) {
    for (RodGroup& group : groups) {
        const OwnedRods own = owned_rods(rods, group.id());
        const std::size_t slots = static_cast<std::size_t>(group.slots()), state = slots * slot_doubles;
        const auto memory = static_cast<std::size_t>(
            comm.max(own.places.empty() ? std::int64_t{0} : static_cast<std::int64_t>(rods.memory(own.places.front()).size())));
        const std::size_t length = head + state + budget + memory;
        std::vector<double> records(own.places.size() * length);
        std::vector<int> ranks;
        for (const std::size_t place : own.places) ranks.push_back(assigned[place].rank);
        rods.read(own.places, Copy::canonical, 0, [&](int, std::size_t i, const RodCopy& rod) {
            const std::size_t place = own.places[i];
            double* out = &records[i * length];
            *out++ = std::bit_cast<double>(assigned[place].key);
            *out++ = static_cast<double>(rods.local()[place].gid);
            *out++ = comm.rank();
            std::memcpy(out, rod.state.data(), state * sizeof(double));
            const RodBudget b = rods.budget(place);
            out[state] = b.loads, out[state + 1] = b.walls, out[state + 2] = b.dissipated, out[state + 3] = b.held_before;
            const std::vector<double> remembered = rods.memory(place);
            std::copy(remembered.begin(), remembered.end(), out + state + budget);
        });
        arrived_.push_back(sent_to<double>(comm, records, length, ranks));
        memory_.push_back(memory);

        const std::size_t before = records_.size();
        const std::vector<double>& all = arrived_.back();
        for (std::size_t at = 0; at < all.size(); at += length)
            records_.push_back({std::bit_cast<std::uint64_t>(all[at]), static_cast<std::int64_t>(all[at + 1]),
                                static_cast<std::int64_t>(all[at + 2]), &all[at + head]});
        std::sort(records_.begin() + static_cast<std::ptrdiff_t>(before), records_.end(),
                  [](const Record& a, const Record& b) { return std::tie(a.key, a.gid) < std::tie(b.key, b.gid); });
        std::vector<std::int64_t> indices;
        for (std::size_t i = before; i < records_.size(); ++i) {
            owned_.push_back({records_[i].gid, group.id(), records_[i].gid - group.first_gid()});
            indices.push_back(owned_.back().index);
            moved_ += records_[i].from != comm.rank();
        }
        move_places(comm, group.places(), own.indices, ranks, indices);
    }
    moved_ = comm.sum(moved_);
}

std::span<const Slot<1>> Migration::state(std::size_t i) const {
    const auto slots = static_cast<std::size_t>(groups_[static_cast<std::size_t>(owned_[i].group)].slots());
    return {reinterpret_cast<const Slot<1>*>(records_[i].numbers), slots};
}

void Migration::put_into(Rods& rods) const {
    for (std::size_t i = 0; i < owned_.size(); ++i) { // one by one: rods of a tile share what is put there
        const std::span<const Slot<1>> own = state(i);
        const double* behind = records_[i].numbers + own.size() * slot_doubles;
        rods.import_rod(i, own);
        rods.set_budget(i, {behind[0], behind[1], behind[2], behind[3]});
        if (const std::size_t numbers = memory_[static_cast<std::size_t>(owned_[i].group)]; numbers > 0)
            rods.set_memory(i, {behind + budget, numbers});
    }
}

} // namespace skein
