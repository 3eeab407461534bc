#include "parallel/threads.hpp"

#include "parallel/pieces.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace skein {
namespace {

class ThreadsTest : public testing::TestWithParam<int> {};

TEST_P(ThreadsTest, visit_every_item_once) {
    const Threads threads(GetParam());
    std::vector<std::atomic<int>> visits(1000);
    threads.for_each(visits.size(), [&](std::size_t i, int) { ++visits[i]; });
    for (const auto& count : visits) EXPECT_EQ(count, 1);
    threads.for_each(0, [](std::size_t, int) { FAIL(); });
}

TEST_P(ThreadsTest, share_pieces) {
    const Threads threads(GetParam());
    for (const Threads* team : {&threads, static_cast<const Threads*>(nullptr)}) {
        std::vector<int> visits(1003, 0), pieces(11, 0);
        in_pieces(team, visits.size(), 100,
                  [&](std::size_t begin, std::size_t end, std::size_t thread, std::size_t piece) {
                      EXPECT_LT(thread, threads_in(team));
                      EXPECT_EQ(begin, 100 * piece);
                      ++pieces[piece];
                      for (std::size_t i = begin; i < end; ++i) ++visits[i];
                  });
        EXPECT_EQ(std::count(visits.begin(), visits.end(), 1), 1003);
        EXPECT_EQ(std::count(pieces.begin(), pieces.end(), 1), 11);
        in_pieces(team, 0, 100, [](std::size_t, std::size_t, std::size_t, std::size_t) { FAIL(); });
    }
}

TEST_P(ThreadsTest, report_the_first_of_the_faults_of_pieces) {
    const Threads threads(GetParam());
    for (int trial = 0; trial < 20; ++trial) try {
            in_pieces(&threads, 640, 10, [](std::size_t, std::size_t, std::size_t, std::size_t piece) {
                if (piece % 9 == 4) throw std::runtime_error(std::to_string(piece));
            });
            FAIL();
        } catch (const std::runtime_error& fault) {
            EXPECT_STREQ(fault.what(), "4");
        }
}

TEST_P(ThreadsTest, have_numbers_that_no_two_bear_at_a_time) {
    const Threads threads(GetParam());
    EXPECT_EQ(threads.count(), GetParam());
    std::vector<std::atomic<int>> bearers(static_cast<std::size_t>(threads.count()));
    std::atomic<int> clashes = 0, strangers = 0;
    threads.for_each(200, [&](std::size_t, int thread) {
        if (thread < 0 || thread >= threads.count()) {
            ++strangers;
            return;
        }
        auto& bearer = nth(bearers, thread);
        if (++bearer != 1) ++clashes;
        std::this_thread::yield();
        --bearer;
    });
    EXPECT_EQ(strangers, 0);
    EXPECT_EQ(clashes, 0);
}

TEST_P(ThreadsTest, hand_on_an_exception) {
    const Threads threads(GetParam());
    try {
        threads.for_each(100, [](std::size_t i, int) {
            if (i == 57) throw std::runtime_error("item 57");
        });
        FAIL();
    } catch (const std::runtime_error& error) {
        EXPECT_EQ(error.what(), std::string("item 57"));
    }
}

TEST_P(ThreadsTest, shuffle_every_loop_anew) {
    const Threads threads(GetParam(), 3);
    constexpr std::size_t n = 100;
    std::vector<std::size_t> orders[2];
    for (auto& order : orders) {
        std::mutex mutex;
        threads.for_each(n, [&](std::size_t i, int) {
            const std::lock_guard lock(mutex);
            order.push_back(i);
        });
        EXPECT_FALSE(std::is_sorted(order.begin(), order.end()));
    }
    EXPECT_NE(orders[0], orders[1]);
    for (auto& order : orders) {
        std::sort(order.begin(), order.end());
        for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(order[i], i);
    }
}

INSTANTIATE_TEST_SUITE_P(Counts, ThreadsTest, testing::Values(1, 2, 5));

TEST(Threads, are_by_default_as_many_as_the_cores_allowed) {
    EXPECT_GE(Threads::available_cores(), 1);
    EXPECT_EQ(Threads(0).count(), Threads::available_cores());
}

} // namespace
} // namespace skein
