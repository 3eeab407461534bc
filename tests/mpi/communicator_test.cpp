#include "parallel/communicator.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <numeric>

namespace skein {
namespace {

struct CommunicatorTest : testing::Test {
    const Communicator comm = Communicator::world();
};

TEST_F(CommunicatorTest, reduces) {
    const std::int64_t rank = comm.rank(), size = comm.size();
    EXPECT_EQ(comm.sum(rank + 1), size * (size + 1) / 2);
    EXPECT_EQ(comm.max(-rank), 0);
    EXPECT_EQ(comm.min(-rank), 1 - size);
    EXPECT_EQ(comm.max(0.5 * static_cast<double>(rank)), 0.5 * static_cast<double>(size - 1));
    EXPECT_EQ(comm.min(0.5 * static_cast<double>(rank)), 0.0);
    const std::uint64_t half = 1ull << 63;
    EXPECT_EQ(comm.sum_wrapping(half), size % 2 ? half : 0);
    std::vector<std::int64_t> sums{rank, 1};
    comm.sum(sums);
    EXPECT_EQ(sums, (std::vector<std::int64_t>{size * (size - 1) / 2, size}));
    std::vector<double> largest{static_cast<double>(rank), -static_cast<double>(rank)};
    comm.max(largest);
    EXPECT_EQ(largest, (std::vector<double>{static_cast<double>(size - 1), 0}));
}

TEST_F(CommunicatorTest, spreads_what_root_has) {
    EXPECT_EQ(comm.broadcast(comm.root() ? std::string("from root") : std::string("not this, and longer")),
              "from root");
    EXPECT_EQ(comm.broadcast(std::string()), "");
    EXPECT_EQ(comm.broadcast(std::int64_t{comm.root() ? 7 : 8}), 7);
    std::vector<std::int64_t> ranks(static_cast<std::size_t>(comm.size()));
    std::iota(ranks.begin(), ranks.end(), 0);
    EXPECT_EQ(comm.all_gather(comm.rank()), ranks);
    std::vector<std::string> texts;
    for (int r = 0; r < comm.size(); ++r) texts.push_back(std::string(static_cast<std::size_t>(r), 'x'));
    EXPECT_EQ(comm.all_gather(nth(texts, comm.rank())), texts);
}

TEST_F(CommunicatorTest, first_text_is_that_of_the_lowest_rank_that_has_one) {
    EXPECT_EQ(comm.first_text(""), "");
    const int last = comm.size() - 1;
    EXPECT_EQ(comm.first_text(comm.rank() == last ? "last" : ""), "last");
    EXPECT_EQ(comm.first_text(std::to_string(comm.rank())), "0");
}

/// Rank r sends (r + s) % 3 records to rank s, each naming both and its number.
struct Record {
    std::int32_t from, to, number;
};

TEST_F(CommunicatorTest, all_to_all_keeps_rank_order) {
    const auto records_between = [](int from, int to) { return (from + to) % 3; };
    std::vector<Record> sent;
    std::vector<std::int64_t> send_counts, receive_counts;
    std::int64_t to_others = 0;
    for (int to = 0; to < comm.size(); ++to) {
        const int count = records_between(comm.rank(), to);
        send_counts.push_back(count);
        if (to != comm.rank()) to_others += count;
        for (int k = 0; k < count; ++k) sent.push_back({comm.rank(), to, k});
    }
    const auto before = Communicator::traffic();
    const auto bytes = comm.all_to_all(std::as_bytes(std::span(sent)), sizeof(Record), send_counts, receive_counts);
    EXPECT_EQ(Communicator::traffic().bytes - before.bytes, to_others * static_cast<std::int64_t>(sizeof(Record)));
    EXPECT_GT(Communicator::traffic().calls, before.calls);

    std::size_t place = 0;
    for (int from = 0; from < comm.size(); ++from) {
        EXPECT_EQ(nth(receive_counts, from), records_between(from, comm.rank()));
        for (int k = 0; k < records_between(from, comm.rank()); ++k, ++place) {
            Record record;
            ASSERT_LE((place + 1) * sizeof record, bytes.size());
            std::memcpy(&record, &bytes[place * sizeof record], sizeof record);
            EXPECT_EQ(record.from, from);
            EXPECT_EQ(record.to, comm.rank());
            EXPECT_EQ(record.number, k);
        }
    }
    EXPECT_EQ(bytes.size(), place * sizeof(Record));
}

} // namespace
} // namespace skein
