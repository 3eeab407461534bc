#include "partition/partition.hpp"

#include "core/hilbert.hpp"
#include "rod/time_limits.hpp"
#include "skein/core/error.hpp"

#include <algorithm>
#include <bit>
#include <limits>

namespace skein {

namespace {

struct Keyed {
    std::uint64_t key;
    std::int64_t gid;

    friend auto operator<=>(const Keyed&, const Keyed&) = default;
};

/// The rods of all groups by gid.
class Roster {
public:
    explicit Roster(std::span<const RodGroup> groups) : groups_(groups) {}

    std::int64_t count() const { return groups_.empty() ? 0 : groups_.back().first_gid() + groups_.back().count(); }
    const RodGroup& group_of(std::int64_t gid) const {
        const auto after = std::upper_bound(groups_.begin(), groups_.end(), gid,
                                            [](std::int64_t g, const RodGroup& group) { return g < group.first_gid(); });
        return *(after - 1);
    }
    std::int64_t weight(std::int64_t gid) const { return group_of(gid).elements(); }

private:
    std::span<const RodGroup> groups_;
};

/// The smallest cube with its sides along the axes that holds every rod's centre.
struct Cube {
    Vec3d corner;
    double side;
};

Cube bounding_cube(const Communicator& comm, std::span<const Vec3d> centres) {
    constexpr double lowest = std::numeric_limits<double>::lowest();
    double bounds[6] = {lowest, lowest, lowest, lowest, lowest, lowest}; // of x, y, z, -x, -y, -z
    for (const Vec3d& c : centres) {
        const double values[6] = {c.x, c.y, c.z, -c.x, -c.y, -c.z};
        for (int i = 0; i < 6; ++i) bounds[i] = std::max(bounds[i], values[i]);
    }
    comm.max(bounds);
    return {{-bounds[3], -bounds[4], -bounds[5]}, std::max({bounds[0] + bounds[3], bounds[1] + bounds[4], bounds[2] + bounds[5]})};
}

std::uint64_t key_in(const Cube& cube, const Vec3d& centre) {
    if (!(cube.side > 0)) return 0;
    const Vec3d offset = centre - cube.corner;
    return hilbert_key({offset.x / cube.side, offset.y / cube.side, offset.z / cube.side});
}

/// This rank's index block of every group, sorted along the curve. Whose block a rod is in changes nothing.
std::vector<Keyed> key_block(const Communicator& comm, std::span<const RodGroup> groups) {
    std::vector<Vec3d> centres;
    std::vector<Keyed> rods;
    for (const RodGroup& group : groups) {
        const std::int64_t end = block_begin(group.count(), comm.rank() + 1, comm.size());
        for (std::int64_t i = block_begin(group.count(), comm.rank(), comm.size()); i < end; ++i) {
            centres.push_back(group.centre(i));
            rods.push_back({0, group.first_gid() + i});
        }
    }
    const Cube cube = bounding_cube(comm, centres);
    for (std::size_t i = 0; i < rods.size(); ++i) rods[i].key = key_in(cube, centres[i]);
    std::sort(rods.begin(), rods.end());
    return rods;
}

/// Weight on all ranks of the rods that come before each place.
class WeightBefore {
public:
    WeightBefore(const Communicator& comm, const Roster& roster, std::span<const Keyed> rods) : comm_(comm), rods_(rods) {
        for (const Keyed& rod : rods) before_.push_back(before_.back() + roster.weight(rod.gid));
    }
    std::int64_t total() const { return comm_.sum(before_.back()); }
    std::vector<std::int64_t> operator()(std::span<const Keyed> places) const {
        std::vector<std::int64_t> weights;
        for (const Keyed& place : places)
            weights.push_back(
                before_[static_cast<std::size_t>(std::lower_bound(rods_.begin(), rods_.end(), place) - rods_.begin())]);
        comm_.sum(weights);
        return weights;
    }

private:
    const Communicator& comm_;
    std::span<const Keyed> rods_;
    std::vector<std::int64_t> before_{0};
};

/// Where the pieces of ranks 1, 2, ... begin: piece r with the first rod that has at least r/P of the whole weight before it.
/// So every of `pieces` is within one rod of its share. All cuts are bisected at once, in the numbers (key, gid).
std::vector<Keyed> find_cuts(const Communicator& comm, const Roster& roster, std::span<const Keyed> rods, int pieces) {
    using Place = unsigned __int128;
    const WeightBefore weight_before(comm, roster, rods);
    const int gid_bits = std::bit_width(static_cast<std::uint64_t>(roster.count()));
    const auto keyed = [gid_bits](Place place) {
        const Place gid = place & ((Place(1) << gid_bits) - 1);
        return Keyed{static_cast<std::uint64_t>(place >> gid_bits), static_cast<std::int64_t>(gid)};
    };

    const auto cuts = static_cast<std::size_t>(pieces - 1);
    const std::int64_t whole = weight_before.total();
    std::vector<Place> low(cuts, 0), high(cuts, Place(1) << (63 + gid_bits));
    std::vector<Keyed> middle(cuts);
    while (low != high) {
        for (std::size_t c = 0; c < cuts; ++c) middle[c] = keyed(low[c] + (high[c] - low[c]) / 2);
        const auto weights = weight_before(middle);
        for (std::size_t c = 0; c < cuts; ++c) {
            const Place place = low[c] + (high[c] - low[c]) / 2;
            if (weights[c] >= block_begin(whole, static_cast<int>(c) + 1, pieces)) high[c] = place;
            else low[c] = place + 1;
        }
    }
    std::vector<Keyed> found;
    for (const Place place : low) found.push_back(keyed(place));
    return found;
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
    const auto bytes = comm.all_to_all(std::as_bytes(rods), sizeof(Keyed), send_counts, receive_counts);
    std::vector<Keyed> owned(bytes.size() / sizeof(Keyed));
    std::copy(bytes.begin(), bytes.end(), std::as_writable_bytes(std::span(owned)).begin());
    std::sort(owned.begin(), owned.end());
    return owned;
}

} // namespace

OwnedRods owned_rods(const Rods& rods, int group) {
    OwnedRods owned;
    for (std::size_t i = 0; i < rods.local().size(); ++i)
        if (rods.local()[i].group == group) owned.places.push_back(i), owned.indices.push_back(rods.local()[i].index);
    return owned;
}

std::int64_t block_begin(std::int64_t count, int part, int parts) { return count / parts * part + count % parts * part / parts; }

void read_rods(const Communicator& comm, std::span<RodGroup> groups) {
    std::string error;
    std::vector<RodGroup*> read;
    for (RodGroup& group : groups)
        if (group.places().waits()) read.push_back(&group);
    for (RodGroup* group : read) try {
            group->places().read(block_begin(group->count(), comm.rank(), comm.size()),
                                 block_begin(group->count(), comm.rank() + 1, comm.size()));
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
        if (group->sized()) {
            limits = least_limits_of_rods(*group);
            for (double& dt : limits) dt = comm.min(dt);
        }
        group->set_read({-lowest[0], -lowest[1], -lowest[2]}, comm.sum_wrapping(group->places().digest()), limits);
    }
}

void keep_own_rods(const Communicator& comm, std::span<RodGroup> groups, std::span<const LocalRod> own) {
    std::vector<std::vector<std::int64_t>> indices(groups.size());
    for (const LocalRod& rod : own) indices[static_cast<std::size_t>(rod.group)].push_back(rod.index);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        Places& places = groups[g].places();
        if (comm.min(static_cast<std::int64_t>(places.holds_all()))) {
            places.keep(indices[g]);
            continue;
        }
        const auto records = IndexBlocks(comm, indices[g], places.count()).to_owners(places.records(), places.record_bytes());
        places.keep(indices[g], records);
    }
}

std::vector<LocalRod> partition(const Communicator& comm, std::span<const RodGroup> groups) {
    const Roster roster(groups);
    const auto rods = key_block(comm, groups);
    const auto owned = send_to_owners(comm, rods, find_cuts(comm, roster, rods, comm.size()));

    std::vector<LocalRod> local;
    for (const Keyed& rod : owned) {
        const RodGroup& group = roster.group_of(rod.gid);
        local.push_back({rod.gid, group.id(), rod.gid - group.first_gid()});
    }
    std::stable_sort(local.begin(), local.end(), [](const LocalRod& a, const LocalRod& b) { return a.group < b.group; });
    return local;
}

std::vector<int> owners(std::span<const RodGroup> groups, int ranks) {
    const Communicator alone = Communicator::alone();
    const Roster roster(groups);
    const auto rods = key_block(alone, groups);
    const auto cuts = find_cuts(alone, roster, rods, ranks);
    std::vector<int> owner(static_cast<std::size_t>(roster.count()));
    for (const Keyed& rod : rods)
        owner[static_cast<std::size_t>(rod.gid)] = static_cast<int>(std::upper_bound(cuts.begin(), cuts.end(), rod) - cuts.begin());
    return owner;
}

} // namespace skein
