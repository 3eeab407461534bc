// Slots of the whole scene by number: those of all bodies one after another, in order of gid. No rank holds an array of
// them.
#pragma once

#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

/// Joining of a body's elements with consecutive numbers: open as a rod's, closed as a ring's, or none.
enum class Chain : std::uint8_t { open, ring, none };

class SceneSlots {
public:
    /// Bodies with equally many slots each.
    struct Alike {
        std::int64_t bodies, slots;
        Chain chain = Chain::open;
        std::int64_t first_kin = -1, kin_per_copy = 0,
                     per_copy = 0; ///< first body of its assembly, see kin_of; bodies in a copy
    };
    explicit SceneSlots(std::span<const Alike> groups);
    explicit SceneSlots(std::span<const RodGroup> groups);

    std::int64_t bodies() const { return bodies_; }
    std::int64_t count() const { return slots_; }
    int group_of(std::int64_t gid) const;
    std::int64_t first_slot(std::int64_t gid) const; ///< first slot of a body
    std::int64_t slots_of(std::int64_t gid) const;
    Chain chain_of(std::int64_t gid) const;
    std::int64_t gid_at(std::int64_t slot) const;
    /// True where some bodies belong to assemblies. Bodies of one copy do not touch each other.
    bool has_kin() const { return has_kin_; }
    /// Number shared by all bodies of a copy of an assembly: gid of its first one. Any other body has its own gid.
    std::int64_t kin_of(std::int64_t gid) const;
    /// Number of the body's block, rising with gid. Blocks are consecutive bodies with no more than block_slots()
    /// slots, or one body. One task sums the loads of a block, so sums depend on the scene alone.
    std::int64_t block_of(std::int64_t gid) const;
    /// A contact that begins within 5/4 of this share of an element from a vertex follows one of the neighbour.
    /// theory.md (59e)
    double vertex_reach() const { return vertex_reach_; }

    /// Slots of a block: a sixteenth of the scene, for threads to share. At least 256 fill the packs. At most 1024 keep
    /// what contacts read and write in the second cache.
    std::int64_t block_slots() const { return block_slots_; }

private:
    struct Group {
        std::int64_t first_gid, first_slot, slots; ///< the last of one body
        Chain chain;
        std::int64_t first_kin, kin_per_copy, per_copy;
    };
    /// Blocks of so many bodies each; bodies of later groups may fill up the last.
    struct Run {
        std::int64_t first_gid, first_block, last_block, bodies;
    };
    const Group& at(std::int64_t gid) const { return nth(groups_, group_of(gid)); }
    std::vector<Group> groups_;
    std::vector<Run> runs_;
    std::int64_t bodies_ = 0, slots_ = 0;
    std::int64_t block_slots_;
    double vertex_reach_ = 0.05;
    bool has_kin_ = false;
};

} // namespace skein
