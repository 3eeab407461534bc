#include "partition/partition.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace skein {

namespace {

/// Sends every record to its rank.
std::vector<std::byte> send(const Communicator& comm, std::span<const std::byte> records, std::size_t record_bytes,
                            std::span<const int> rank) {
    std::vector<std::size_t> order(rank.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return rank[i] < rank[j]; });
    std::vector<std::byte> sorted(records.size());
    std::vector<std::int64_t> counts(to_index(comm.size()), 0), received;
    for (std::size_t i = 0; i < order.size(); ++i) {
        std::memcpy(sorted.data() + i * record_bytes, records.data() + order[i] * record_bytes, record_bytes);
        ++nth(counts, rank[order[i]]);
    }
    return comm.all_to_all(sorted, record_bytes, counts, received);
}

} // namespace

int OwnerDirectory::block_of(std::int64_t gid) const {
    int low = 0, high = comm_.size(); // the last block that begins at or before it
    while (high - low > 1) {
        const int middle = low + (high - low) / 2;
        (block_begin(bodies_, middle, comm_.size()) <= gid ? low : high) = middle;
    }
    return low;
}

OwnerDirectory::OwnerDirectory(const Communicator& comm, std::span<const std::int64_t> own, std::int64_t bodies)
    : comm_(comm), bodies_(bodies) {
    struct Owned {
        std::int64_t gid, rank;
    };
    std::vector<Owned> mine;
    std::vector<int> block;
    for (const std::int64_t gid : own) {
        mine.push_back({gid, comm_.rank()});
        block.push_back(block_of(gid));
    }
    const std::vector<std::int64_t> received =
        records_of<std::int64_t>(send(comm_, std::as_bytes(std::span(mine)), sizeof(Owned), block));
    const std::int64_t first = block_begin(bodies_, comm_.rank(), comm_.size());
    owner_.resize(to_index(block_begin(bodies_, comm_.rank() + 1, comm_.size()) - first));
    for (std::size_t i = 0; i < received.size(); i += 2)
        nth(owner_, received[i] - first) = static_cast<int>(received[i + 1]);
}

std::vector<std::byte> OwnerDirectory::to_blocks(std::span<const std::byte> records, std::size_t record_bytes,
                                                 std::span<const std::int64_t> gids) const {
    std::vector<int> block;
    for (const std::int64_t gid : gids) block.push_back(block_of(gid));
    return send(comm_, records, record_bytes, block);
}

std::vector<std::byte> OwnerDirectory::to_owners(std::span<const std::byte> records, std::size_t record_bytes,
                                                 std::span<const std::int64_t> gids) const {
    const std::vector<std::byte> here = to_blocks(records, record_bytes, gids);
    const std::int64_t first = block_begin(bodies_, comm_.rank(), comm_.size());
    std::vector<int> owner;
    for (const std::int64_t gid : records_of<std::int64_t>(to_blocks(std::as_bytes(gids), sizeof(std::int64_t), gids)))
        owner.push_back(nth(owner_, gid - first));
    return send(comm_, here, record_bytes, owner);
}

} // namespace skein
