// Clusters: tiles that advance together, as their rods are joined. A cluster is a block of W copies of an assembly, one
// per lane, so that a joint is between the same slots in all lanes; or one copy, whose rods of a group lie side by
// side. Bits are the same.
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/tiles/tile.hpp"
#include "tiles/end_moments.hpp"
#include "tiles/rods.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace skein {

/// How the copies of an assembly that a rank has are laid out.
struct CopyTiling {
    std::vector<int> across; ///< copies in each block of up to W, one per lane
    std::int64_t within = 0; ///< copies by themselves, behind them

    std::int64_t copies() const;
};

/// Rods of a group in a copy.
struct MemberRods {
    std::int64_t rods;
    int slots;
};
/// What keeps all threads busy with the fewest rows.
CopyTiling tile_copies(std::int64_t copies, std::span<const MemberRods> members, int lanes, int threads);

/// Tiles of a copy by itself that a group has.
inline std::int64_t tiles_within(std::int64_t rods, int lanes) { return (rods + lanes - 1) / lanes; }

/// Assemblies whose groups these are, in order; each with its groups.
struct AssemblyGroups {
    int assembly;
    std::vector<const RodGroup*> groups;

    std::vector<MemberRods> members() const;
    std::int64_t rods_per_copy() const;
    std::int64_t elements_per_copy() const;
};
std::vector<AssemblyGroups> assemblies_of(std::span<const RodGroup> groups);

/// For each of `owned`, ordered by group: where it stands once the rods of assemblies are in the order of their tiles.
/// Copies keep the order in which the first group of an assembly has them.
std::vector<std::size_t> order_of_tiles(std::span<const RodGroup> groups, std::span<const LocalRod> owned, int lanes,
                                        int threads);

/// Loads that the members of a cluster exert on each other, by slot of the cluster.
template <int W> struct JoinedLoad {
    Vec3<Pack<W>> force;  ///< at the node, lab, N
    Vec3<Pack<W>> couple; ///< on the element, body, N m
};

/// What joins the rods of an assembly. Slots of a cluster are those of its tiles one after another: of a block of
/// copies, tile by tile, the rods of each group in turn; of one copy its groups' tiles in turn.
template <int W> class ClusterJoints {
public:
    virtual ~ClusterJoints() = default;
    /// Sets the loads of all slots. `across`: the cluster is a block of copies. `moments`: by tile of the cluster, null
    /// where wants_moments() is false.
    virtual void run(const Slot<W>* slot, const EndMoments<W>* moments, JoinedLoad<W>* load, bool across) const = 0;
    /// True where moments of muscles go on through joints.
    virtual bool wants_moments() const { return false; }
    /// True where nodes of several rods are one; only then are the next two called.
    virtual bool shares_nodes() const { return false; }
    /// After a drift, before loads: takes such nodes to one place.
    virtual void gather(Slot<W>*, bool) const {}
    /// After a kick: gives them one velocity.
    virtual void move_as_one(Slot<W>*, const Step&, bool) const {}
};

/// Before the kick: loads that joints have found.
template <int W> class TakeJoinedLoadsPass final : public TilePass<W> {
public:
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        if (!rod.joined) return;
        for (int k = 0; k <= rod.last; ++k) {
            load[k].force += rod.joined[k].force;
            load[k].couple += rod.joined[k].couple;
        }
    }
};

} // namespace skein
