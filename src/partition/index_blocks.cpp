#include "partition/partition.hpp"

#include <cstring>

namespace skein {

namespace {

/// The part that holds item i, see block_begin().
int part_of(std::int64_t i, std::int64_t count, int parts) { return static_cast<int>((parts * (i + 1) - 1) / count); }

} // namespace

IndexBlocks::IndexBlocks(const Communicator& comm, std::span<const std::int64_t> owned_indices, std::int64_t count)
    : comm_(comm), begin_(block_begin(count, comm.rank(), comm.size())),
      size_(block_begin(count, comm.rank() + 1, comm.size()) - begin_), send_counts_(static_cast<std::size_t>(comm.size()), 0),
      send_order_(owned_indices.size()) {
    for (const auto index : owned_indices) ++send_counts_[static_cast<std::size_t>(part_of(index, count, comm.size()))];
    std::vector<std::int64_t> next(send_counts_.size(), 0);
    for (std::size_t r = 1; r < next.size(); ++r) next[r] = next[r - 1] + send_counts_[r - 1];

    std::vector<std::int64_t> sent(owned_indices.size());
    for (std::size_t i = 0; i < owned_indices.size(); ++i) {
        const auto place = next[static_cast<std::size_t>(part_of(owned_indices[i], count, comm.size()))]++;
        send_order_[static_cast<std::size_t>(place)] = static_cast<std::int64_t>(i);
        sent[static_cast<std::size_t>(place)] = owned_indices[i];
    }
    const auto bytes = comm.all_to_all(std::as_bytes(std::span(sent)), sizeof(std::int64_t), send_counts_, receive_counts_);
    receive_index_.resize(bytes.size() / sizeof(std::int64_t));
    if (!bytes.empty()) std::memcpy(receive_index_.data(), bytes.data(), bytes.size());
    for (auto& index : receive_index_) index -= begin_;
}

namespace {

/// out[to[i]] = in[i]
std::vector<std::byte> scatter(std::span<const std::byte> in, std::span<const std::int64_t> to, std::size_t count,
                               std::size_t bytes) {
    std::vector<std::byte> out(count * bytes);
    for (std::size_t i = 0; i < to.size(); ++i) std::memcpy(&out[static_cast<std::size_t>(to[i]) * bytes], &in[i * bytes], bytes);
    return out;
}

/// out[i] = in[from[i]]
std::vector<std::byte> gather(std::span<const std::byte> in, std::span<const std::int64_t> from, std::size_t bytes) {
    std::vector<std::byte> out(from.size() * bytes);
    for (std::size_t i = 0; i < from.size(); ++i)
        std::memcpy(&out[i * bytes], &in[static_cast<std::size_t>(from[i]) * bytes], bytes);
    return out;
}

} // namespace

std::vector<std::byte> IndexBlocks::to_blocks(std::span<const std::byte> owned, std::size_t record_bytes) const {
    std::vector<std::int64_t> counts;
    const auto arrived = comm_.all_to_all(gather(owned, send_order_, record_bytes), record_bytes, send_counts_, counts);
    return scatter(arrived, receive_index_, static_cast<std::size_t>(size_), record_bytes);
}

std::vector<std::byte> IndexBlocks::to_owners(std::span<const std::byte> block, std::size_t record_bytes) const {
    std::vector<std::int64_t> counts;
    const auto arrived = comm_.all_to_all(gather(block, receive_index_, record_bytes), record_bytes, receive_counts_, counts);
    return scatter(arrived, send_order_, send_order_.size(), record_bytes);
}

} // namespace skein
