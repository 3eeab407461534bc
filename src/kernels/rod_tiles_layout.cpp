// Layout of rods: tiles across and along, clusters of joined ones, the memory of all, and their start states.
#include "kernels/rod_tiles.hpp"

#include "core/rotation.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <utility>

namespace skein {

namespace {

/// Copies of an assembly that these rods have.
template <int W> CopyTiling copy_tiling(const AssemblyGroups& assembly, std::span<const LocalRod> rods, int threads) {
    const int leader = assembly.groups.front()->id();
    const auto own = std::count_if(rods.begin(), rods.end(), [&](const LocalRod& rod) { return rod.group == leader; });
    return assembly.tiling(own / assembly.groups.front()->rods_per_copy(), W, threads);
}

/// Tiles of each group that belongs to an assembly, in order; none of others.
template <int W> std::vector<std::vector<int>> lanes_of_joined_tiles(std::span<const RodGroup> groups,
                                                                     std::span<const LocalRod> rods, int threads) {
    std::vector<std::vector<int>> lanes(groups.size());
    for (const AssemblyGroups& assembly : assemblies_of(groups)) {
        const CopyTiling tiling = copy_tiling<W>(assembly, rods, threads);
        for (const RodGroup* group : assembly.groups) {
            std::vector<int>& of_group = nth(lanes, group->id());
            const std::int64_t in_copy = group->rods_per_copy();
            for (const int copies : tiling.across)
                of_group.insert(of_group.end(), static_cast<std::size_t>(in_copy), copies);
            for (std::int64_t copy = 0; copy < tiling.within; ++copy)
                for (std::int64_t left = in_copy; left > 0; left -= W)
                    of_group.push_back(static_cast<int>(std::min<std::int64_t>(left, W)));
        }
    }
    return lanes;
}

} // namespace

template <int W> std::vector<typename RodTiles<W>::AlongLayout> RodTiles<W>::lay_out(const Tiling& tiling) {
    std::vector<std::size_t> tiles_of_program(programs_.size(), 0);
    place_.resize(local_.size());
    fill_across(tiling.across, tiles_of_program);
    std::vector<AlongLayout> layouts = fill_along(tiling.along, tiles_of_program);
    for (std::size_t p = 0; p < programs_.size(); ++p) // of groups that all lie along, or that have no rod here
        if (tiles_of_program[p] == 0) programs_[p] = {};
    for (std::size_t p = 0; p < programs_.size(); ++p)
        for (auto& pass : programs_[p].passes) pass->expect(tiles_of_program[p]);
    find_clusters();
    give_slots();
    return layouts;
}

template <int W>
RodTile<W>& RodTiles<W>::open(RodTile<W> tile, std::size_t program, std::vector<std::size_t>& tiles_of_program) {
    tile.program = program;
    tile.number = tiles_of_program[program]++;
    return tiles_.emplace_back(tile);
}

template <int W>
void RodTiles<W>::fill_across(std::vector<std::int64_t> across, std::vector<std::size_t>& tiles_of_program) {
    std::vector<std::size_t> place_in_group(groups_.size(), 0);
    const auto has_own = [&](const LocalRod& rod) { return nth(groups_, rod.group).heterogeneous(); };
    std::size_t own_program = programs_.size(); // of the first rod with constants of its own
    for (std::vector<std::int64_t> left = across; const LocalRod& rod : local_)
        if (nth(left, rod.group)-- > 0 && has_own(rod)) --own_program;
    std::vector<std::vector<int>> lanes_of_tiles = lanes_of_joined_tiles<W>(groups_, local_, threads_.count());
    for (std::size_t i = 0; i < local_.size(); ++i) {
        const auto g = static_cast<std::size_t>(local_[i].group);
        if (across[g]-- <= 0) {
            along_.push_back(i);
            continue;
        }
        const RodGroup& group = groups_[g].kind(local_[i].index);
        const std::size_t program = has_own(local_[i]) ? own_program++ : g;
        const int most_lanes =
            lanes_of_tiles[g].empty() || tiles_of_program[g] == 0 ? W : lanes_of_tiles[g][tiles_of_program[g] - 1];
        const bool opens = tiles_.empty() || tiles_.back().group != &group || tiles_.back().lanes == most_lanes;
        RodTile<W>& tile = opens ? open({.slot = nullptr,
                                         .element = group.element.data(),
                                         .voronoi = group.voronoi.data(),
                                         .group = &group,
                                         .n = group.elements(),
                                         .last = group.slots() - 1,
                                         .first = place_in_group[g]},
                                        program, tiles_of_program)
                                 : tiles_.back();
        if (opens) first_rod_.push_back(i);
        place_[i] = {tiles_.size() - 1, tile.lanes};
        ++place_in_group[g];
        std::fill(tile.index + tile.lanes, tile.index + W, local_[i].index); // spare lanes repeat the last rod
        ++tile.lanes;
    }
}

template <int W> std::vector<typename RodTiles<W>::AlongLayout>
RodTiles<W>::fill_along(std::span<const AlongTile> tiles, std::vector<std::size_t>& tiles_of_program) {
    std::vector<std::vector<std::size_t>> pool(groups_.size()); // rods that lie along, by group
    for (const std::size_t i : along_) nth(pool, local_[i].group).push_back(i);
    std::vector<std::size_t> next(groups_.size(), 0);
    std::vector<AlongLayout> layouts;
    for (const AlongTile& along : tiles) {
        auto& [ranges, rods] = layouts.emplace_back();
        int l = 0;
        for (const auto& [g, pieces] : along.parts) {
            const auto group = static_cast<std::size_t>(g);
            const std::size_t i = pool[group][next[group]++];
            ranges.push_back({&groups_[group], local_[i].index, l, pieces});
            rods.push_back(i);
            place_[i] = {tiles_.size(), l};
            l += pieces;
        }
        RodTile<W>& tile = open({.n = along.rows, .lanes = static_cast<int>(ranges.size())},
                                groups_.size() + static_cast<std::size_t>(along.family), tiles_of_program);
        if (!ranges.front().group->heterogeneous()) continue;
        tile.group = ranges.front().group; // which all share
        tile.first = next[to_index(tile.group->id())] - ranges.size();
        for (std::size_t s = 0; s < ranges.size(); ++s) tile.index[s] = ranges[s].index;
    }
    return layouts;
}

template <int W> void RodTiles<W>::give_slots() {
    const auto slots_of = [&](std::size_t t) { return static_cast<std::size_t>(tiles_[t].last) + 1; };
    std::size_t slots = 0;
    for (std::size_t t = 0; t < tiles_.size(); ++t) slots += slots_of(t);
    for (const Cluster& cluster : clusters_) slots += cluster.joints->has_world();
    slots_ = UnsetArray<Slot<W>>(slots);
    Slot<W>* next_slot = slots_.data();
    const auto give = [&](std::size_t t) { tiles_[t].slot = std::exchange(next_slot, next_slot + slots_of(t)); };
    for (const Cluster& cluster : clusters_) {
        for (const std::size_t t : cluster.tiles) give(t);
        next_slot += cluster.joints->has_world();
    }
    for (const std::size_t t : alone_) give(t);
}

template <int W> void RodTiles<W>::find_clusters() {
    cluster_of_.assign(tiles_.size(), SIZE_MAX);
    std::vector<std::vector<std::size_t>> of_group(groups_.size());
    for (std::size_t t = 0; t < tiles_.size(); ++t)
        if (tiles_[t].group) nth(of_group, tiles_[t].group->id()).push_back(t);
    for (const AssemblyGroups& assembly : assemblies_of(groups_)) {
        const auto a = static_cast<std::size_t>(assembly.assembly);
        if (a >= joints_.size() || !joints_[a]) continue;  // of a test's rods
        std::vector<std::size_t> taken(groups_.size(), 0); // tiles of each group
        const CopyTiling tiling = copy_tiling<W>(assembly, local_, threads_.count());
        const auto add = [&](bool across) {
            Cluster& cluster = clusters_.emplace_back(Cluster{joints_[a].get(), across, {}});
            for (const RodGroup* group : assembly.groups) {
                const auto g = static_cast<std::size_t>(group->id());
                const std::int64_t tiles = across ? group->rods_per_copy() : tiles_within(group->rods_per_copy(), W);
                for (std::int64_t i = 0; i < tiles; ++i) {
                    const std::size_t t = of_group[g][taken[g]++];
                    cluster.tiles.push_back(t);
                    cluster.slots += static_cast<std::size_t>(tiles_[t].last) + 1;
                    cluster_of_[t] = clusters_.size() - 1;
                }
            }
            cluster.slots += cluster.joints->has_world();
        };
        for (std::size_t block = 0; block < tiling.across.size(); ++block) add(true);
        for (std::int64_t copy = 0; copy < tiling.within; ++copy) add(false);
    }
    for (std::size_t t = 0; t < tiles_.size(); ++t)
        if (cluster_of_[t] == SIZE_MAX) alone_.push_back(t);
}

template <int W> void RodTiles<W>::join_steps() {
    for (Cluster& cluster : clusters_) {
        for (const std::size_t t : cluster.tiles)
            if (const StepsTogether<W>* pass = programs_[tiles_[t].program].together())
                cluster.stepped.push_back({pass, tiles_[t]});
        if (cluster.stepped.empty()) continue;
        std::shared_ptr<ClusterStep<W>>& step = steps_[cluster.joints];
        if (!step)
            step = std::make_shared<ClusterStep<W>>(*cluster.joints, cluster.stepped, cluster.slots, threads_.count());
        cluster.step = step;
    }
}

template <int W> void RodTiles<W>::place_worlds() {
    for (const Cluster& cluster : clusters_) {
        if (!cluster.joints->has_world()) continue;
        const RodTile<W>& tile = tiles_[cluster.tiles.front()];
        Slot<W>& world = tile.slot[cluster.slots - 1];
        for (int l = 0; l < W; ++l) set_lane(world, l, world_of(*tile.group, tile.index[cluster.across ? l : 0]));
    }
}

template <int W> void RodTiles<W>::take_start_states(std::vector<AlongLayout> layouts) {
    const std::size_t across = first_rod_.size();
    place_worlds();
    strands_ = std::vector<std::optional<Strands<W>>>(layouts.size());
    // The loop of a visit: threads take much the same tiles then, whose memory has come to them here.
    threads_.for_each(tiles_.size(), [&](std::size_t t, int thread) {
        Reading& reading = nth(reading_, thread);
        if (t < across) take_start_states(tiles_[t], first_rod_[t], reading.state);
        else lay_out_along(tiles_[t], layouts[t - across], strands_[t - across], reading);
    });
    for (Reading& reading : reading_) reading.own = {};
    for (std::size_t t = 0; t < across; ++t)
        for (auto& pass : programs_[tiles_[t].program].passes) pass->bind(tiles_[t]);
}

template <int W>
const RodGroup& RodTiles<W>::own_group(Reading& reading, std::size_t place, const RodGroup& group, std::int64_t index) {
    std::vector<RodGroup>& own = reading.own;
    if (!own.empty() && own.front().id() != group.id()) own.clear();
    own.reserve(W); // which keeps them in their places
    if (place >= own.size()) return own.emplace_back(group.single(index));
    own[place].become(group, index);
    return own[place];
}

template <int W> void RodTiles<W>::lay_out_along(RodTile<W>& tile, AlongLayout& layout,
                                                 std::optional<Strands<W>>& strands, Reading& reading) {
    auto& [ranges, rods] = layout;
    const RodGroup& group =
        *ranges.front().group; // rods with sizes of their own share tiles with those of their group alone
    if (group.heterogeneous())
        for (std::size_t s = 0; s < ranges.size(); ++s)
            ranges[s].group = &own_group(reading, s, group, ranges[s].index);
    strands.emplace(ranges, tile.n);
    tile.strands = &*strands;
    const Slot<1> still{{0, 0, 0}, {0, 0, 0}, broadcast<1>(no_turn), {0, 0, 0}};
    for (int row = 0; row <= tile.n; ++row)
        for (int i = 0; i < W; ++i) {
            set_lane(tile.slot[row], i, still);
            const int slot = tile.strands->slot(i, row);
            if (slot == tile.group_of(i).elements())
                set_lane(tile.slot[row].director, i, tile.group_of(i).end_frame(tile.index_of(i)));
        }
    for (std::size_t s = 0; s < rods.size(); ++s) {
        const auto slots = static_cast<std::size_t>(ranges[s].group->slots());
        if (reading.state.size() < slots) reading.state.resize(slots);
        const std::span state = std::span(reading.state).first(slots);
        ranges[s].group->start_state(ranges[s].index, state);
        import_rod(rods[s], state);
    }
    for (auto& pass : programs_[tile.program].passes) pass->bind(tile);
    if (group.heterogeneous()) strands->settle(group);
    layout = {};
}

template <int W>
void RodTiles<W>::take_start_states(const RodTile<W>& tile, std::size_t first_rod, std::vector<Slot<1>>& states) const {
    const auto slots = static_cast<std::size_t>(tile.last) + 1;
    states.resize(W * slots);
    for (int i = 0; i < tile.lanes; ++i)
        tile.group->start_state(local_[first_rod + static_cast<std::size_t>(i)].index,
                                std::span(states).subspan(static_cast<std::size_t>(i) * slots, slots));
    const double* from = reinterpret_cast<const double*>(states.data());
    double* to = reinterpret_cast<double*>(tile.slot);
    for (std::size_t number = 0; number < slots * slot_doubles; ++number)
        for (int i = 0; i < W; ++i)
            *to++ = from[static_cast<std::size_t>(std::min(i, tile.lanes - 1)) * slots * slot_doubles + number];
}

template std::vector<RodTiles<SKEIN_WIDTH>::AlongLayout> RodTiles<SKEIN_WIDTH>::lay_out(const Tiling& tiling);
template void RodTiles<SKEIN_WIDTH>::join_steps();
template void RodTiles<SKEIN_WIDTH>::take_start_states(std::vector<AlongLayout> layouts);
template const RodGroup& RodTiles<SKEIN_WIDTH>::own_group(Reading& reading, std::size_t place, const RodGroup& group,
                                                          std::int64_t index);

} // namespace skein
