#include "studies/shared_bodies.hpp"

#include "mechanics/rod_copies.hpp"
#include "physics/walls/wall_interaction.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <tuple>
#include <type_traits>
#include <utility>

namespace skein {

namespace {

static_assert(sizeof(Slot<1>) % sizeof(double) == 0);
constexpr std::size_t slot_numbers = sizeof(Slot<1>) / sizeof(double);

/// A body as numbers: its own in the scene, those of its slots, how many its memory at walls has, and these, and the
/// same of all that a run keeps.
void append_body(const World& world, const WallInteraction* walls, std::size_t i, std::vector<double>& to) {
    const LocalRod& rod = world.rods().local()[i];
    const RodGroup& group = nth(world.groups, rod.group);
    std::vector<Slot<1>> state(to_index(group.slots()));
    world.rods().export_rod(i, state);
    with_rod(group, rod.index, [&](const RodGroup& one) { synchronise(one, state, world.clock.lag()); });
    to.push_back(static_cast<double>(rod.gid));
    const std::size_t at = to.size();
    to.resize(at + state.size() * slot_numbers);
    std::memcpy(&to[at], state.data(), state.size() * sizeof(Slot<1>));
    const std::vector<double> memory = walls ? walls->memory(i) : std::vector<double>();
    to.push_back(static_cast<double>(memory.size()));
    to.insert(to.end(), memory.begin(), memory.end());
    const std::vector<double> all = world.rods().memory(i);
    to.push_back(static_cast<double>(all.size()));
    to.insert(to.end(), all.begin(), all.end());
}

LocalRod rod_of(std::span<const RodGroup> groups, std::int64_t gid) {
    const auto behind = std::upper_bound(groups.begin(), groups.end(), gid,
                                         [](std::int64_t g, const RodGroup& group) { return g < group.first_gid(); });
    const RodGroup& group = *(behind - 1);
    return {gid, group.id(), gid - group.first_gid()};
}

} // namespace

SharedBodies share_bodies(const World& world, std::span<const std::size_t> own, bool of_all) {
    const WallInteraction* walls = walls_of(world.interactions());
    std::vector<double> mine;
    std::vector<std::pair<std::int64_t, std::size_t>> here; // number in the scene and place, rising
    for (const std::size_t i : own) {
        append_body(world, walls, i, mine);
        here.emplace_back(world.rods().local()[i].gid, i);
    }
    std::sort(here.begin(), here.end());
    const std::vector<double> numbers = of_all ? world.comm.all_gather(mine) : std::move(mine);

    std::vector<std::pair<LocalRod, const double*>> found;
    for (const double* at = numbers.data(); at < numbers.data() + numbers.size();) {
        const LocalRod rod = rod_of(world.groups, static_cast<std::int64_t>(*at));
        found.emplace_back(rod, ++at);
        at += to_index(nth(world.groups, rod.group).slots()) * slot_numbers;
        for (int part = 0; part < 2; ++part) at += 1 + static_cast<std::size_t>(*at);
    }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first.gid < b.first.gid; });
    SharedBodies all;
    all.first.push_back(0);
    for (const auto& [rod, state] : found) {
        const auto at = std::lower_bound(here.begin(), here.end(), std::pair(rod.gid, std::size_t{0}));
        all.rods.push_back(rod);
        all.local.push_back(at != here.end() && at->first == rod.gid ? at->second : SharedBodies::elsewhere);
        const std::size_t slots = to_index(nth(world.groups, rod.group).slots());
        all.slot.resize(all.first.back() + slots);
        std::memcpy(static_cast<void*>(&all.slot[all.first.back()]), state, slots * sizeof(Slot<1>));
        const double* memory = state + slots * slot_numbers;
        for (auto* part : {&all.wall_memory, &all.memory}) {
            const double* end = memory + 1 + static_cast<std::size_t>(*memory);
            part->emplace_back(memory + 1, end);
            memory = end;
        }
        all.first.push_back(all.slot.size());
    }
    return all;
}

std::vector<RodGroup> groups_of_all(const World& world) {
    const Communicator& comm = world.comm;
    std::vector<RodGroup> groups = world.groups;
    for (RodGroup& group : groups) {
        Places& places = group.places();
        if (comm.min(static_cast<std::int64_t>(places.holds_all()))) continue;
        const std::vector<std::int64_t> held = places.held();
        const auto counts = comm.all_gather(static_cast<std::int64_t>(held.size()));
        const std::size_t total = to_index(std::accumulate(counts.begin(), counts.end(), std::int64_t{0}));
        std::vector<std::int64_t> indices(total);
        comm.all_gather(std::as_bytes(std::span(held)), sizeof(std::int64_t), counts,
                        std::as_writable_bytes(std::span(indices)));
        std::vector<std::byte> records(total * places.record_bytes());
        comm.all_gather(places.records(), places.record_bytes(), counts, records);
        places.keep(indices, records);
    }
    return groups;
}

std::vector<SavedContact> contact_memory_of_all(const Communicator& comm, std::vector<SavedContact> own) {
    static_assert(std::is_trivially_copyable_v<SavedContact>);
    const auto counts = comm.all_gather(static_cast<std::int64_t>(own.size()));
    std::vector<SavedContact> all(to_index(std::accumulate(counts.begin(), counts.end(), std::int64_t{0})));
    comm.all_gather(std::as_bytes(std::span(own)), sizeof(SavedContact), counts,
                    std::as_writable_bytes(std::span(all)));
    std::sort(all.begin(), all.end(),
              [](const SavedContact& x, const SavedContact& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); });
    return all;
}

} // namespace skein
