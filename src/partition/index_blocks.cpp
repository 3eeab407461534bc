#include "partition/partition.hpp"
#include "skein/core/index.hpp"

#include <cstring>
#include <numeric>

namespace skein {

namespace {

/// The part that holds item i, see block_begin().
int part_of(std::int64_t i, std::int64_t count, int parts) { return static_cast<int>((parts * (i + 1) - 1) / count); }

} // namespace

IndexBlocks::IndexBlocks(const Communicator& comm, std::span<const std::int64_t> owned_indices, std::int64_t count)
    : comm_(comm), begin_(block_begin(count, comm.rank(), comm.size())),
      size_(block_begin(count, comm.rank() + 1, comm.size()) - begin_), send_counts_(to_index(comm.size()), 0),
      send_order_(owned_indices.size()) {
    for (const auto index : owned_indices) ++nth(send_counts_, part_of(index, count, comm.size()));
    std::vector<std::int64_t> next(send_counts_.size(), 0);
    for (std::size_t r = 1; r < next.size(); ++r) next[r] = next[r - 1] + send_counts_[r - 1];

    std::vector<std::int64_t> sent(owned_indices.size());
    for (std::size_t i = 0; i < owned_indices.size(); ++i) {
        const auto place = nth(next, part_of(owned_indices[i], count, comm.size()))++;
        nth(send_order_, place) = static_cast<std::int64_t>(i);
        nth(sent, place) = owned_indices[i];
    }
    receive_index_ = records_of<std::int64_t>(
        comm.all_to_all(std::as_bytes(std::span(sent)), sizeof(std::int64_t), send_counts_, receive_counts_));
    for (auto& index : receive_index_) index -= begin_;

    const auto me = to_index(comm.rank());
    const std::int64_t own_begin =
        std::accumulate(send_counts_.begin(), send_counts_.begin() + comm.rank(), std::int64_t{0});
    sent_ = owned_indices.size() - to_index(send_counts_[me]);
    destination_.resize(owned_indices.size());
    for (std::size_t place = 0; place < send_order_.size(); ++place) {
        const auto i = to_index(send_order_[place]), before = to_index(own_begin);
        const auto own = to_index(send_counts_[me]);
        if (place < before) destination_[i] = {false, place};
        else if (place < before + own) destination_[i] = {true, to_index(owned_indices[i] - begin_)};
        else destination_[i] = {false, place - own};
    }
}

void IndexBlocks::send(std::span<const std::byte> records, std::size_t record_bytes,
                       const std::function<void(std::size_t, const std::byte*)>& arrived) const {
    std::vector<std::int64_t> counts = send_counts_, received;
    nth(counts, comm_.rank()) = 0;
    const auto bytes = comm_.all_to_all(records.first(sent_ * record_bytes), record_bytes, counts, received);
    const std::byte* record = bytes.data();
    std::size_t i = 0; // among all that this rank receives, its own in their turn
    for (int rank = 0; rank < comm_.size(); ++rank) {
        const auto count = to_index(nth(receive_counts_, rank));
        if (rank != comm_.rank())
            for (std::size_t k = i; k < i + count; ++k, record += record_bytes)
                arrived(to_index(receive_index_[k]), record);
        i += count;
    }
}

void RecordBuffers::begin(const IndexBlocks& blocks, std::size_t record_bytes) {
    blocks_ = &blocks;
    record_bytes_ = record_bytes;
    block_.need(to_index(blocks.size()) * record_bytes);
    sent_.need(blocks.sent() * record_bytes);
}

std::span<const std::byte> RecordBuffers::exchange() {
    blocks_->send({sent_.data(), blocks_->sent() * record_bytes_}, record_bytes_,
                  [&](std::size_t place, const std::byte* record) {
                      std::memcpy(block_.data() + place * record_bytes_, record, record_bytes_);
                  });
    return {block_.data(), to_index(blocks_->size()) * record_bytes_};
}

namespace {

/// out[to[i]] = in[i]
std::vector<std::byte> scatter(std::span<const std::byte> in, std::span<const std::int64_t> to, std::size_t count,
                               std::size_t bytes) {
    std::vector<std::byte> out(count * bytes);
    for (std::size_t i = 0; i < to.size(); ++i) std::memcpy(&out[to_index(to[i]) * bytes], &in[i * bytes], bytes);
    return out;
}

/// out[i] = in[from[i]]
std::vector<std::byte> gather(std::span<const std::byte> in, std::span<const std::int64_t> from, std::size_t bytes) {
    std::vector<std::byte> out(from.size() * bytes);
    for (std::size_t i = 0; i < from.size(); ++i) std::memcpy(&out[i * bytes], &in[to_index(from[i]) * bytes], bytes);
    return out;
}

} // namespace

std::vector<std::byte> IndexBlocks::to_owners(std::span<const std::byte> block, std::size_t record_bytes) const {
    std::vector<std::int64_t> counts;
    const auto arrived =
        comm_.all_to_all(gather(block, receive_index_, record_bytes), record_bytes, receive_counts_, counts);
    return scatter(arrived, send_order_, send_order_.size(), record_bytes);
}

} // namespace skein
