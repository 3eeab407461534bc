#include "neighbourhood/scene_slots.hpp"

#include "rod/body_shape.hpp"

#include <algorithm>

namespace skein {

namespace {

/// The last of those that begin at or before a number; the first begins at 0.
template <class T> const T& last_before(const std::vector<T>& all, std::int64_t number, std::int64_t T::*first) {
    return *(
        std::upper_bound(all.begin(), all.end(), number, [first](std::int64_t n, const T& t) { return n < t.*first; }) -
        1);
}

std::vector<SceneSlots::Alike> alike(std::span<const RodGroup> groups) {
    std::vector<SceneSlots::Alike> all;
    for (const RodGroup& group : groups) {
        const Chain chain = !group.strained() ? Chain::none : group.closed() ? Chain::ring : Chain::open;
        all.push_back({group.count(), group.exposed_slots(), chain});
        if (!group.assembly()) continue;
        const RodGroup& first = *std::find_if(groups.begin(), groups.end(), [&](const RodGroup& other) {
            return other.assembly() && other.assembly()->number == group.assembly()->number;
        });
        all.back().first_kin = first.first_gid();
        all.back().kin_per_copy = first.rods_per_copy();
        all.back().per_copy = group.rods_per_copy();
    }
    return all;
}

} // namespace

SceneSlots::SceneSlots(std::span<const RodGroup> groups) : SceneSlots(alike(groups)) {
    for (const RodGroup& group : groups)
        for_each_kind(group, [&](const RodGroup& rod, double) {
            for (const ElementConstants& c : rod.element)
                if (rod.strained())
                    vertex_reach_ = std::max(vertex_reach_, std::min(0.4 * c.radius / c.rest_length, 0.25));
        });
}

SceneSlots::SceneSlots(std::span<const Alike> groups) {
    std::int64_t all = 0;
    for (const auto& group : groups) all += group.bodies * group.slots;
    block_slots_ = std::clamp<std::int64_t>(all / 16, 256, 1024);
    std::int64_t block = 0, room = 0; // in the last block
    for (const auto& [bodies, slots, chain, first_kin, kin_per_copy, per_copy] : groups) {
        const std::int64_t first = bodies_;
        groups_.push_back({first, slots_, slots, chain, first_kin, kin_per_copy, per_copy});
        has_kin_ |= first_kin >= 0;
        bodies_ += bodies;
        slots_ += bodies * slots;
        const std::int64_t joining = std::min(room / slots, bodies), // the block that the group before has begun
            left = bodies - joining;
        room -= joining * slots;
        if (left == 0) continue;
        const std::int64_t in_block = std::max<std::int64_t>(1, block_slots_ / slots);
        const std::int64_t blocks = (left + in_block - 1) / in_block;
        runs_.push_back({first + joining, block, block + blocks - 1, in_block});
        block += blocks;
        const std::int64_t in_last = (left - 1) % in_block + 1;
        room = std::max<std::int64_t>(0, block_slots_ - in_last * slots);
    }
}

int SceneSlots::group_of(std::int64_t gid) const {
    return static_cast<int>(&last_before(groups_, gid, &Group::first_gid) - groups_.data());
}

std::int64_t SceneSlots::first_slot(std::int64_t gid) const {
    const Group& g = at(gid);
    return g.first_slot + (gid - g.first_gid) * g.slots;
}

std::int64_t SceneSlots::slots_of(std::int64_t gid) const { return at(gid).slots; }

Chain SceneSlots::chain_of(std::int64_t gid) const { return at(gid).chain; }

std::int64_t SceneSlots::gid_at(std::int64_t slot) const {
    const Group& g = last_before(groups_, slot, &Group::first_slot);
    return g.first_gid + (slot - g.first_slot) / g.slots;
}

std::int64_t SceneSlots::kin_of(std::int64_t gid) const {
    const Group& g = at(gid);
    return g.first_kin < 0 ? gid : g.first_kin + (gid - g.first_gid) / g.per_copy * g.kin_per_copy;
}

std::int64_t SceneSlots::block_of(std::int64_t gid) const {
    const Run& run = last_before(runs_, gid, &Run::first_gid);
    return std::min(run.first_block + (gid - run.first_gid) / run.bodies, run.last_block);
}

} // namespace skein
