// Clusters: tiles that advance together because joints connect their rods. A cluster is a block of W copies of an
// assembly, one per lane, so that a joint connects the same slots in all lanes. Or it is one copy, whose rods of a
// group lie side by side. Bits are the same.
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

/// Layout of the copies of an assembly on a rank.
struct CopyTiling {
    std::vector<int> across; ///< copies in each block of up to W, one per lane
    std::int64_t within = 0; ///< further copies, each in a cluster of its own

    std::int64_t copies() const;
};

/// Rods of a group in a copy.
struct MemberRods {
    std::int64_t rods;
    int slots;
};
/// Layout that keeps all threads busy with the fewest rows.
CopyTiling tile_copies(std::int64_t copies, std::span<const MemberRods> members, int lanes, int threads);
/// Layout of copies that have a lane each.
CopyTiling tile_copies_across(std::int64_t copies, int lanes);

/// Number of tiles of a group in the cluster of a single copy.
inline std::int64_t tiles_within(std::int64_t rods, int lanes) { return (rods + lanes - 1) / lanes; }

/// Assemblies of these groups, in order, each with its groups.
struct AssemblyGroups {
    int assembly;
    std::vector<const RodGroup*> groups;

    std::vector<MemberRods> members() const;
    CopyTiling tiling(std::int64_t copies, int lanes, int threads) const;
    std::int64_t rods_per_copy() const;
    std::int64_t elements_per_copy() const;
};
std::vector<AssemblyGroups> assemblies_of(std::span<const RodGroup> groups);

/// Place of each of `owned`, ordered by group, once the rods of assemblies are in the order of their tiles. Copies keep
/// the order in which the first group of an assembly has them.
std::vector<std::size_t> order_of_tiles(std::span<const RodGroup> groups, std::span<const LocalRod> owned, int lanes,
                                        int threads);

/// Sizes of such loads, summed joint by joint, as joints may balance each other. Only loads with slopes have them.
template <int W> struct JoinedSize {};
template <> struct JoinedSize<dual> {
    double force_size = 0, couple_size = 0; ///< N, N m
};
/// Loads of joints between members of a cluster, by slot of the cluster.
template <int W> struct JoinedLoad : JoinedSize<W> {
    Vec3<Pack<W>> force;  ///< force on the node, lab, N
    Vec3<Pack<W>> couple; ///< couple on the element, body, N m
};

/// The world as one side of joints: a body at the origin of rod i's copy, in its axes, that does not move.
Slot<1> world_of(const RodGroup& group, std::int64_t i);

/// Node of a cluster that goes with another one, or with a place of a body.
struct SharedSlot {
    std::uint32_t slot, leader;
    bool on_body;
    Vec3d arm; ///< from the body's centre to the node, body axes, m
};

/// A rod of a cluster: its group, number in the copy, and lane of its copy.
struct JoinedRod {
    int group;
    std::int64_t rod;
    int lane;
};

/// Joints of an assembly. Slots of a cluster are those of its tiles one after another: in a block of copies tile by
/// tile, the rods of each group in turn; in a single copy the tiles of its groups in turn. The world, if any, is last.
template <int W> class ClusterJoints {
public:
    virtual ~ClusterJoints() = default;
    /// True where joints have a slot of the world.
    virtual bool has_world() const = 0;
    /// Takes the numbers of motors for the steps to come.
    virtual void prepare(std::span<const Step> steps) = 0;
    /// Sets the loads of all slots. `across`: true where the cluster is a block of copies. `moments`: by tile of the
    /// cluster, null where wants_moments() is false. `memory`: that of the cluster's joints from step to step.
    virtual void run(const Slot<W>* slot, const EndMoments<W>* moments, const Step& step, Pack<W>* memory,
                     JoinedLoad<W>* load, bool across) const = 0;
    /// Slots that the loads of each joint depend on and act on, in a block of copies.
    virtual std::vector<std::vector<std::uint32_t>> joined_slots() const = 0;
    /// Prepares motors for the ends of steps, too.
    virtual void use_ends() = 0;
    /// Nodes that go with others, leaders first, in a block of copies.
    virtual std::vector<SharedSlot> shared_slots() const { return {}; }
    /// Lanes in which shared slot i still goes with its leader.
    virtual Mask<W> goes_along(std::size_t i, const Pack<W>* memory) const = 0;
    /// Sets the loads of a block of copies in a state within an implicit step, which joints do not remember.
    virtual void try_state(const Slot<W>* slot, const EndMoments<W>* moments, const Step& step, const Pack<W>* memory,
                           JoinedLoad<W>* load) const = 0;
    /// Joints that remember nothing yet remember the state that an implicit step begins with, after the drift of a bed.
    /// Joints that ended with the stage before come to an end. `load`: room, as below.
    virtual void begin_step(const Slot<W>* slot, const Step& step, Pack<W>* memory, JoinedLoad<W>* load) const = 0;
    /// Joints remember a state that ends an implicit step. They are made, and come to an end.
    virtual void end_step(const Slot<W>* slot, const Step& step, Pack<W>* memory, JoinedLoad<W>* load) const = 0;
    /// Takes the numbers of a cluster's copies, one a lane of a block, for motors whose formulas hold `rod`: at the
    /// start, and again when their tables change.
    virtual void set_rods(Pack<W>* memory, bool across, std::span<const std::int64_t> copies) const = 0;
    /// Packs of memory of a cluster, zero at the start.
    virtual std::size_t memory_packs(bool across) const = 0;
    /// Memory of the joints whose first side is a rod, for checkpoints.
    virtual void append_memory(const Pack<W>* memory, bool across, JoinedRod rod,
                               std::vector<double>& numbers) const = 0;
    virtual void restore(Pack<W>* memory, bool across, JoinedRod rod, std::span<const double> numbers) const = 0;
    /// True where moments of muscles act through joints.
    virtual bool wants_moments() const { return false; }
    /// True where several rods share a node; only then are the next two functions called.
    virtual bool shares_nodes() const { return false; }
    /// Moves shared nodes to one place, after a drift and before loads; `memory` as in run().
    virtual void gather(Slot<W>*, const Pack<W>*, bool) const {}
    /// Gives shared nodes one velocity, after a kick.
    virtual void move_as_one(Slot<W>*, const Pack<W>*, const Step&, bool) const {}
};

/// Adds the loads of joints, before the kick.
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
