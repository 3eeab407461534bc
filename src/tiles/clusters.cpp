#include "tiles/clusters.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

namespace skein {

std::int64_t CopyTiling::copies() const { return std::accumulate(across.begin(), across.end(), within); }

CopyTiling tile_copies_across(std::int64_t copies, int lanes) {
    CopyTiling tiling;
    for (std::int64_t left = copies; left > 0; left -= lanes)
        tiling.across.push_back(static_cast<int>(std::min<std::int64_t>(left, lanes)));
    return tiling;
}

CopyTiling tile_copies(std::int64_t copies, std::span<const MemberRods> members, int lanes, int threads) {
    constexpr double tile_rows = 2; // rows of time that a tile costs besides its own
    // time of a row within, whose joints are gathered, over that of a row across
    constexpr double gathered_joints = 1.5;
    double of_block = 0, of_copy = 0;
    for (const auto& [rods, slots] : members) {
        of_block += static_cast<double>(rods) * (slots + tile_rows);
        of_copy += gathered_joints * static_cast<double>(tiles_within(rods, lanes)) * (slots + tile_rows);
    }
    CopyTiling best;
    double least = std::numeric_limits<double>::infinity();
    const auto consider = [&](std::int64_t blocks) {
        const std::int64_t within = std::max<std::int64_t>(0, copies - blocks * lanes);
        const double total = static_cast<double>(blocks) * of_block + static_cast<double>(within) * of_copy;
        const double rounds = static_cast<double>((blocks + threads - 1) / threads);
        const double time = std::max({total / threads, rounds * of_block, within > 0 ? of_copy : 0});
        if (time >= least) return;
        least = time;
        best = {{}, within};
        best.across = tile_copies_across(copies - within, lanes).across;
    };
    for (std::int64_t blocks = (copies + lanes - 1) / lanes; blocks >= 0; --blocks) consider(blocks);
    return best;
}

std::vector<MemberRods> AssemblyGroups::members() const {
    std::vector<MemberRods> all;
    for (const RodGroup* group : groups) all.push_back({group->rods_per_copy(), group->slots()});
    return all;
}

CopyTiling AssemblyGroups::tiling(std::int64_t copies, int lanes, int threads) const {
    const bool unlike = std::any_of(groups.begin(), groups.end(), [](const RodGroup* g) { return g->heterogeneous(); });
    if (unlike) return tile_copies_across(copies, 1); // tiles of such rods have one lane
    if (groups.front()->assembly()->lane_each) return tile_copies_across(copies, lanes);
    return tile_copies(copies, members(), lanes, threads);
}

std::int64_t AssemblyGroups::rods_per_copy() const {
    std::int64_t rods = 0;
    for (const RodGroup* group : groups) rods += group->rods_per_copy();
    return rods;
}

std::int64_t AssemblyGroups::elements_per_copy() const {
    std::int64_t elements = 0;
    for (const RodGroup* group : groups) elements += group->rods_per_copy() * group->elements();
    return elements;
}

std::vector<AssemblyGroups> assemblies_of(std::span<const RodGroup> groups) {
    std::map<int, AssemblyGroups> found;
    for (const RodGroup& group : groups) {
        if (!group.assembly()) continue;
        AssemblyGroups& one = found[group.assembly()->number];
        one.assembly = group.assembly()->number;
        one.groups.push_back(&group);
    }
    std::vector<AssemblyGroups> all;
    for (auto& [number, one] : found) all.push_back(std::move(one));
    return all;
}

Slot<1> world_of(const RodGroup& group, std::int64_t i) {
    Slot<1> slot{broadcast<1>(nth(group.assembly()->origins, group.copy_of(i))), {}, broadcast<1>(no_turn), {}};
    set_lane(slot.director, 0, group.copy_axes(i));
    return slot;
}

std::vector<std::size_t> order_of_tiles(std::span<const RodGroup> groups, std::span<const LocalRod> owned, int lanes,
                                        int threads) {
    std::vector<std::size_t> order(owned.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::vector<std::size_t> first(groups.size() + 1, 0); // first rod of each group in `owned`
    for (const LocalRod& rod : owned) ++first[to_index(rod.group) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    for (const AssemblyGroups& assembly : assemblies_of(groups)) {
        std::map<std::int64_t, std::int64_t> place; // place of a copy among those of this rank
        const std::size_t leader = to_index(assembly.groups.front()->id());
        for (std::size_t i = first[leader]; i < first[leader + 1]; ++i)
            place.emplace(groups[leader].copy_of(owned[i].index), static_cast<std::int64_t>(place.size()));
        const CopyTiling tiling = assembly.tiling(static_cast<std::int64_t>(place.size()), lanes, threads);
        const std::int64_t in_blocks = tiling.copies() - tiling.within;
        for (const RodGroup* group : assembly.groups) {
            const std::size_t g = to_index(group->id());
            const auto key = [&](std::size_t i) {
                const std::int64_t copy = place.at(group->copy_of(owned[i].index)),
                                   rod = owned[i].index % group->rods_per_copy();
                const std::int64_t block = copy < in_blocks ? copy / lanes : copy;
                return copy < in_blocks ? std::tuple(block, rod, copy) : std::tuple(block, copy, rod);
            };
            std::sort(order.begin() + static_cast<std::ptrdiff_t>(first[g]),
                      order.begin() + static_cast<std::ptrdiff_t>(first[g + 1]),
                      [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
        }
    }
    return order;
}

} // namespace skein
