// Owners of rods. A space-filling curve through the rods' centres is cut into one piece of equal weight per rank. At
// the start the weights are numbers of elements, so the scene alone decides. Later they are the rods' costs at their
// present places.
#pragma once

#include "parallel/communicator.hpp"
#include "skein/core/aligned.hpp"
#include "skein/rod/rod_group.hpp"
#include "tiles/rods.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <vector>

namespace skein {

/// Owned rods of this rank, ordered by group and, within a group, along the curve. The weight of a rod is its number of
/// elements. Memory and time per rank are O(N/P). Each rank keys its index block of every group. The cuts are found by
/// bisection on (key, gid) with collective sums of weights. Owners receive their rods in one all_to_all. Collective.
std::vector<LocalRod> partition(const Communicator& comm, std::span<const RodGroup> groups);
/// Rank of each rod, by gid, that so many ranks would give it; worked out by this one alone.
std::vector<int> owners(std::span<const RodGroup> groups, int ranks);

/// A rod somewhere, and the cost of a step of it in any unit.
struct WeighedRod {
    std::int64_t gid;
    Vec3d centre; ///< m
    std::int64_t weight;
};
/// Its place along the curve, and the rank that is to own it.
struct Assignment {
    std::uint64_t key;
    int rank;
};
/// Owners of rods by where they are and what they cost now: every rank gets as much weight as others, within one rod's.
/// `own`: the rods of this rank, in any distribution; the result is in their order. Collective.
std::vector<Assignment> assign(const Communicator& comm, std::span<const WeighedRod> own);

/// Reads the files of rods. Each rank reads its index block of a group (see IndexBlocks), and all agree on what depends
/// on every rod. Groups that have been read, or have no file, are left alone. `threads` share the work of a rank; null:
/// none. Throws InputError on all ranks alike.
/// Collective.
void read_rods(const Communicator& comm, std::span<RodGroup> groups, const Threads* threads = nullptr);

/// From blocks to owners: what is known of single rods goes to the ranks that own them, and is forgotten elsewhere.
/// Collective.
void keep_own_rods(const Communicator& comm, std::span<RodGroup> groups, std::span<const LocalRod> own);

/// A group's rods of this rank: their places in Rods::local(), and their numbers in the group.
struct OwnedRods {
    std::vector<std::size_t> places;
    std::vector<std::int64_t> indices;
};
OwnedRods owned_rods(const Rods& rods, int group);

/// First of the items that part `part` of `parts` holds when `count` items are dealt out in order: floor(part count /
/// parts).
std::int64_t block_begin(std::int64_t count, int part, int parts);

/// Moves fixed-size records between the owners of a group's rods and contiguous blocks of rod index, one per rank. Rank
/// r holds indices [r N/P, (r+1) N/P), the order in which files are written and read. One rank owns each index in [0,
/// count). Calls are collective.
class IndexBlocks {
public:
    IndexBlocks(const Communicator& comm, std::span<const std::int64_t> owned_indices, std::int64_t count);

    std::int64_t begin() const { return begin_; } ///< first index of this rank's block
    std::int64_t size() const { return size_; }
    /// Destination of the record of an owned rod (by its place in owned_indices): this rank's block, or the records to
    /// send.
    struct Destination {
        bool own;
        std::size_t place;
    };
    Destination destination(std::size_t i) const { return destination_[i]; }
    /// Records that go to other ranks.
    std::size_t sent() const { return sent_; }
    /// Sends them, and puts those that arrive into the block: arrived(place in the block, record).
    void send(std::span<const std::byte> records, std::size_t record_bytes,
              const std::function<void(std::size_t place, const std::byte* record)>& arrived) const;
    /// Records of this rank's block, by index -> records of the owned rods, in the order of owned_indices.
    std::vector<std::byte> to_owners(std::span<const std::byte> block, std::size_t record_bytes) const;

private:
    Communicator comm_;
    std::int64_t begin_ = 0, size_ = 0;
    std::vector<std::int64_t> send_counts_, send_order_, receive_counts_, receive_index_;
    std::vector<Destination> destination_;
    std::size_t sent_ = 0;
};

/// Records of a group's rods on their way from owners to blocks. Buffers are kept from one group of records to the
/// next. Records that stay on this rank are stored in place at once.
class RecordBuffers {
public:
    /// Collective calls of `blocks` follow; it must outlive them.
    void begin(const IndexBlocks& blocks, std::size_t record_bytes);
    /// Memory of an owned rod's record. Any thread may call it.
    std::byte* record(std::size_t i) {
        const auto [own, place] = blocks_->destination(i);
        return (own ? block_.data() : sent_.data()) + place * record_bytes_;
    }
    /// Collective: all records of this rank's block, in order of index.
    std::span<const std::byte> exchange();

private:
    const IndexBlocks* blocks_ = nullptr;
    std::size_t record_bytes_ = 0;
    UnsetArray<std::byte> block_, sent_;
};

/// Ways to owners of bodies that only their gids tell of: every rank knows those of its block of gids.
class OwnerDirectory {
public:
    /// `own`: gids; each of [0, bodies) is owned by one rank. Collective.
    OwnerDirectory(const Communicator& comm, std::span<const std::int64_t> own, std::int64_t bodies);

    /// Records of bodies with these gids to the ranks whose blocks they are in: all of lower gids come to lower ranks.
    /// Collective.
    std::vector<std::byte> to_blocks(std::span<const std::byte> records, std::size_t record_bytes,
                                     std::span<const std::int64_t> gids) const;
    /// Sends records to the ranks that own the bodies. Collective.
    std::vector<std::byte> to_owners(std::span<const std::byte> records, std::size_t record_bytes,
                                     std::span<const std::int64_t> gids) const;

private:
    int block_of(std::int64_t gid) const;

    Communicator comm_;
    std::int64_t bodies_;
    std::vector<int> owner_; ///< owners of the gids of this rank's block
};

/// Rows of this rank's block of a group, of numbers that only owners know. Calls row(index, out) for each owned rod.
/// Collective.
template <class Row> std::vector<double>
rows_of_owners(const IndexBlocks& blocks, std::span<const std::int64_t> owned_indices, std::size_t width, Row row) {
    RecordBuffers buffers;
    buffers.begin(blocks, width * sizeof(double));
    std::vector<double> own(width);
    for (std::size_t i = 0; i < owned_indices.size(); ++i) {
        row(owned_indices[i], own.data());
        std::memcpy(buffers.record(i), own.data(), width * sizeof(double));
    }
    return records_of<double>(buffers.exchange());
}

} // namespace skein
