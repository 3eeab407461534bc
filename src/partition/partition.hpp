// Who owns which rod. A space-filling curve through the rods' centres, cut into one piece of equal weight per rank. The curve's
// order depends on the scene alone, so rods keep their neighbours whatever the number of ranks.
#pragma once

#include "parallel/communicator.hpp"
#include "rod/rod_group.hpp"
#include "rod/rods.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace skein {

/// Owned rods of this rank, ordered by group and, within a group, along the curve. Weight of a rod: its elements.
/// O(N/P) memory and time per rank: each rank keys its index block of every group, the cuts are found by bisection on (key, gid)
/// with collective weight sums, and owners receive their rods in one all_to_all. Collective.
std::vector<LocalRod> partition(const Communicator& comm, std::span<const RodGroup> groups);

/// Reads what files say of the rods: each rank its index block of a group (see IndexBlocks), and all agree on what depends on every
/// rod. Groups that have been read, or have no file, are left alone. Throws InputError on all ranks alike. Collective.
void read_rods(const Communicator& comm, std::span<RodGroup> groups);

/// From blocks to owners: what is known of single rods goes to the ranks that own them, and is forgotten elsewhere. Collective.
void keep_own_rods(const Communicator& comm, std::span<RodGroup> groups, std::span<const LocalRod> own);

/// First of the items that part `part` of `parts` holds when `count` items are dealt out in order: floor(part count / parts).
std::int64_t block_begin(std::int64_t count, int part, int parts);

/// Moves fixed-size records between the owners of a group's rods and contiguous blocks of rod index, one block per rank
/// (rank r holds indices [r N/P, (r+1) N/P)): the order in which files are written and read. Every index in [0, count) is owned
/// by one rank. Collective calls.
class IndexBlocks {
public:
    IndexBlocks(const Communicator& comm, std::span<const std::int64_t> owned_indices, std::int64_t count);

    std::int64_t begin() const { return begin_; } ///< first index of this rank's block
    std::int64_t size() const { return size_; }
    /// Records of the owned rods (in the order of owned_indices) -> records of this rank's block, by index.
    std::vector<std::byte> to_blocks(std::span<const std::byte> owned, std::size_t record_bytes) const;
    /// The way back.
    std::vector<std::byte> to_owners(std::span<const std::byte> block, std::size_t record_bytes) const;

private:
    Communicator comm_;
    std::int64_t begin_ = 0, size_ = 0;
    std::vector<std::int64_t> send_counts_, send_order_, receive_counts_, receive_index_;
};

} // namespace skein
