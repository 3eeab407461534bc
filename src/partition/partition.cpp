#include "partition/partition.hpp"

#include "core/hilbert.hpp"
#include "rod/cell_turn.hpp"
#include "rod/time_limits.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "tiles/clusters.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace skein {

namespace {

struct Keyed {
    std::uint64_t key;
    std::int64_t gid;

    friend auto operator<=>(const Keyed&, const Keyed&) = default;
};

std::int64_t rods_of(std::span<const RodGroup> groups) {
    return groups.empty() ? 0 : groups.back().first_gid() + groups.back().count();
}

const RodGroup& group_of(std::span<const RodGroup> groups, std::int64_t gid) {
    const auto after = std::upper_bound(groups.begin(), groups.end(), gid,
                                        [](std::int64_t g, const RodGroup& group) { return g < group.first_gid(); });
    return *(after - 1);
}

const AssemblyGroups& assembly_of(const RodGroup& group, const std::vector<AssemblyGroups>& assemblies) {
    return *std::find_if(assemblies.begin(), assemblies.end(),
                         [&](const AssemblyGroups& a) { return a.assembly == group.assembly()->number; });
}

/// The smallest cube with its sides along the axes that holds every rod's centre.
struct Cube {
    Vec3d corner;
    double side;
};

Cube bounding_cube(const Communicator& comm, std::span<const Vec3d> centres) {
    constexpr double lowest = std::numeric_limits<double>::lowest();
    double bounds[6] = {lowest, lowest, lowest, lowest, lowest, lowest}; // bounds of x, y, z, -x, -y, -z
    for (const Vec3d& c : centres) {
        const double values[6] = {c.x, c.y, c.z, -c.x, -c.y, -c.z};
        for (int i = 0; i < 6; ++i) bounds[i] = std::max(bounds[i], values[i]);
    }
    comm.max(bounds);
    return {{-bounds[3], -bounds[4], -bounds[5]},
            std::max({bounds[0] + bounds[3], bounds[1] + bounds[4], bounds[2] + bounds[5]})};
}

std::uint64_t key_in(const Cube& cube, const Vec3d& centre) {
    const Vec3d offset = centre - cube.corner;
    if (!(cube.side > 0) || !std::isfinite(cube.side) || !std::isfinite(offset.x + offset.y + offset.z))
        return 0; // lost
    return hilbert_key({offset.x / cube.side, offset.y / cube.side, offset.z / cube.side});
}

/// Rods that some rank knows of, in any distribution: their places along the curve, and the weight of those before
/// each.
class Curve {
public:
    /// Collective.
    Curve(const Communicator& comm, std::span<const WeighedRod> rods) : comm_(comm) {
        std::vector<Vec3d> centres;
        std::vector<std::pair<Keyed, std::int64_t>> weighed;
        for (const WeighedRod& rod : rods) centres.push_back(rod.centre);
        const Cube cube = bounding_cube(comm, centres);
        for (const WeighedRod& rod : rods) weighed.push_back({{key_in(cube, rod.centre), rod.gid}, rod.weight});
        std::sort(weighed.begin(), weighed.end());
        for (const auto& [rod, weight] : weighed) {
            rods_.push_back(rod);
            before_.push_back(before_.back() + weight);
        }
        for (const Keyed& rod : rods_) last_gid_ = std::max(last_gid_, rod.gid);
        last_gid_ = comm.max(last_gid_);
    }
    std::span<const Keyed> rods() const { return rods_; }

    /// First rods of the pieces of ranks 1, 2, ... Piece r begins with the first rod that has at least r/P of the whole
    /// weight before it. So each of `pieces` is within one rod of its share. All cuts are bisected at once, in the
    /// numbers (key, gid). Collective.
    std::vector<Keyed> cuts(int pieces) const {
        using Place = unsigned __int128;
        const int gid_bits = std::bit_width(static_cast<std::uint64_t>(last_gid_ + 1));
        const auto keyed = [gid_bits](Place place) {
            const Place gid = place & ((Place(1) << gid_bits) - 1);
            return Keyed{static_cast<std::uint64_t>(place >> gid_bits), static_cast<std::int64_t>(gid)};
        };
        const auto count = to_index(pieces - 1);
        const std::int64_t whole = comm_.sum(before_.back());
        std::vector<Place> low(count, 0), high(count, Place(1) << (63 + gid_bits));
        std::vector<Keyed> middle(count);
        while (low != high) {
            for (std::size_t c = 0; c < count; ++c) middle[c] = keyed(low[c] + (high[c] - low[c]) / 2);
            const auto weights = weight_before(middle);
            for (std::size_t c = 0; c < count; ++c) {
                const Place place = low[c] + (high[c] - low[c]) / 2;
                if (weights[c] >= block_begin(whole, static_cast<int>(c) + 1, pieces)) high[c] = place;
                else low[c] = place + 1;
            }
        }
        std::vector<Keyed> found;
        for (const Place place : low) found.push_back(keyed(place));
        return found;
    }

private:
    /// On all ranks together, of the rods that come before each place.
    std::vector<std::int64_t> weight_before(std::span<const Keyed> places) const {
        std::vector<std::int64_t> weights;
        for (const Keyed& place : places)
            weights.push_back(nth(before_, std::lower_bound(rods_.begin(), rods_.end(), place) - rods_.begin()));
        comm_.sum(weights);
        return weights;
    }

    const Communicator& comm_;
    std::vector<Keyed> rods_;
    std::vector<std::int64_t> before_{0};
    std::int64_t last_gid_ = 0;
};

int piece_of(std::span<const Keyed> cuts, const Keyed& rod) {
    return static_cast<int>(std::upper_bound(cuts.begin(), cuts.end(), rod) - cuts.begin());
}

/// This rank's index block of every group, where rods start. Whose block a rod is in changes nothing. The first rod of
/// a copy of an assembly stands for all of it.
std::vector<WeighedRod> index_block(const Communicator& comm, std::span<const RodGroup> groups) {
    std::vector<WeighedRod> rods;
    const std::vector<AssemblyGroups> assemblies = assemblies_of(groups);
    for (const RodGroup& group : groups) {
        std::int64_t units = group.count(), rods_of_unit = 1, weight = group.elements();
        if (group.assembly()) {
            const AssemblyGroups& whole = assembly_of(group, assemblies);
            if (whole.groups.front() != &group) continue;
            units = group.assembly()->count();
            rods_of_unit = group.rods_per_copy();
            weight = whole.elements_per_copy();
        }
        const std::int64_t end = block_begin(units, comm.rank() + 1, comm.size());
        for (std::int64_t unit = block_begin(units, comm.rank(), comm.size()); unit < end; ++unit) {
            const std::int64_t i = unit * rods_of_unit;
            rods.push_back({group.first_gid() + i, group.centre(i), weight});
        }
    }
    return rods;
}

/// Calls f(group, index) for the rods that one of index_block stands for.
template <class F> void for_rods_of(std::span<const RodGroup> groups, const std::vector<AssemblyGroups>& assemblies,
                                    std::int64_t gid, F&& f) {
    const RodGroup& group = group_of(groups, gid);
    const std::int64_t index = gid - group.first_gid();
    if (!group.assembly()) return f(group, index);
    const std::int64_t copy = group.copy_of(index);
    for (const RodGroup* member : assembly_of(group, assemblies).groups)
        for (std::int64_t i = 0; i < member->rods_per_copy(); ++i) f(*member, copy * member->rods_per_copy() + i);
}

std::vector<Keyed> send_to_owners(const Communicator& comm, std::span<const Keyed> rods, std::span<const Keyed> cuts) {
    std::vector<std::int64_t> send_counts, receive_counts;
    auto begin = rods.begin();
    for (const Keyed& cut : cuts) {
        const auto end = std::lower_bound(begin, rods.end(), cut);
        send_counts.push_back(end - begin);
        begin = end;
    }
    send_counts.push_back(rods.end() - begin);
    std::vector<Keyed> owned =
        records_of<Keyed>(comm.all_to_all(std::as_bytes(rods), sizeof(Keyed), send_counts, receive_counts));
    std::sort(owned.begin(), owned.end());
    return owned;
}

/// The deviation of the rods of all ranks. Collective.
Deviation agreed(const Communicator& comm, const Deviation& own) {
    constexpr std::int64_t many = std::numeric_limits<std::int64_t>::max();
    Deviation all;
    all.distance = comm.max(own.distance);
    all.fewest = comm.min(own.resampled() ? own.fewest : many);
    all.most = comm.max(own.most);
    if (all.resampled()) all.rod = comm.first_text(own.distance == all.distance ? own.rod : "");
    return all;
}

} // namespace

OwnedRods owned_rods(const Rods& rods, int group) {
    OwnedRods owned;
    for (std::size_t i = 0; i < rods.local().size(); ++i)
        if (rods.local()[i].group == group) {
            owned.places.push_back(i);
            owned.indices.push_back(rods.local()[i].index);
        }
    return owned;
}

std::int64_t block_begin(std::int64_t count, int part, int parts) {
    return count / parts * part + count % parts * part / parts;
}

void read_rods(const Communicator& comm, std::span<RodGroup> groups, const Threads* threads) {
    std::string error;
    std::vector<RodGroup*> read;
    std::map<const RodGroup*, LeastLimits> limits_of;
    for (RodGroup& group : groups)
        if (group.places().waits()) read.push_back(&group);
    for (RodGroup* group : read) try {
            const std::int64_t begin = block_begin(group->count(), comm.rank(), comm.size()),
                               end = block_begin(group->count(), comm.rank() + 1, comm.size());
            group->require_memory(end - begin);
            group->places().read(begin, end, threads);
            refuse_large_turns(*group, threads);
            if (group->heterogeneous()) limits_of[group] = least_limits_of_rods(*group, threads);
        } catch (const std::exception& e) {
            error = e.what();
            break;
        }
    error = comm.first_text(error);
    if (!error.empty()) throw InputError(error);
    for (RodGroup* group : read) {
        const Vec3d corner = group->places().corner();
        double lowest[3] = {-corner.x, -corner.y, -corner.z};
        comm.max(lowest);
        LeastLimits limits{};
        if (group->heterogeneous()) {
            limits = limits_of[group];
            for (double& dt : limits) dt = comm.min(dt);
        }
        group->places().set_deviation(agreed(comm, group->places().deviation()));
        group->set_read({-lowest[0], -lowest[1], -lowest[2]}, comm.sum_wrapping(group->places().digest(threads)),
                        limits);
    }
}

void keep_own_rods(const Communicator& comm, std::span<RodGroup> groups, std::span<const LocalRod> own) {
    std::vector<std::vector<std::int64_t>> indices(groups.size());
    for (const LocalRod& rod : own) nth(indices, rod.group).push_back(rod.index);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        Places& places = groups[g].places();
        if (groups[g].heterogeneous() && comm.min(static_cast<std::int64_t>(places.holds_all()))) continue;
        if (comm.min(static_cast<std::int64_t>(places.holds_all()))) {
            places.keep(indices[g]);
            continue;
        }
        const auto records =
            IndexBlocks(comm, indices[g], places.count()).to_owners(places.records(), places.record_bytes());
        places.keep(indices[g], records);
    }
}

std::vector<LocalRod> partition(const Communicator& comm, std::span<const RodGroup> groups) {
    const Curve curve(comm, index_block(comm, groups));
    std::vector<LocalRod> local;
    const std::vector<AssemblyGroups> assemblies = assemblies_of(groups);
    for (const Keyed& rod : send_to_owners(comm, curve.rods(), curve.cuts(comm.size())))
        for_rods_of(groups, assemblies, rod.gid, [&](const RodGroup& group, std::int64_t i) {
            local.push_back({group.first_gid() + i, group.id(), i});
        });
    std::stable_sort(local.begin(), local.end(),
                     [](const LocalRod& a, const LocalRod& b) { return a.group < b.group; });
    return local;
}

std::vector<int> owners(std::span<const RodGroup> groups, int ranks) {
    const Communicator alone = Communicator::alone();
    const Curve curve(alone, index_block(alone, groups));
    const auto cuts = curve.cuts(ranks);
    std::vector<int> owner(to_index(rods_of(groups)));
    const std::vector<AssemblyGroups> assemblies = assemblies_of(groups);
    for (const Keyed& rod : curve.rods())
        for_rods_of(groups, assemblies, rod.gid, [&](const RodGroup& group, std::int64_t i) {
            nth(owner, group.first_gid() + i) = piece_of(cuts, rod);
        });
    return owner;
}

std::vector<Assignment> assign(const Communicator& comm, std::span<const WeighedRod> rods) {
    const Curve curve(comm, rods);
    const auto cuts = curve.cuts(comm.size());
    std::vector<Keyed> by_gid(curve.rods().begin(), curve.rods().end());
    std::sort(by_gid.begin(), by_gid.end(), [](const Keyed& a, const Keyed& b) { return a.gid < b.gid; });
    std::vector<Assignment> assigned;
    for (const WeighedRod& rod : rods) {
        const Keyed& found = *std::lower_bound(by_gid.begin(), by_gid.end(), rod.gid,
                                               [](const Keyed& k, std::int64_t gid) { return k.gid < gid; });
        assigned.push_back({found.key, piece_of(cuts, found)});
    }
    return assigned;
}

} // namespace skein
