#include "io/keeping.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace skein {
namespace {

using Steps = std::vector<std::int64_t>;

TEST(Keeping, keeps_the_newest_and_the_first) {
    EXPECT_EQ(kept_steps(Steps{}, {}), Steps{});
    EXPECT_EQ(kept_steps(Steps{7}, {}), Steps{7});
    EXPECT_EQ(kept_steps(Steps{1, 2, 3}, {5, true}), (Steps{1, 2, 3}));
    EXPECT_EQ(kept_steps(Steps{10, 20, 30, 40}, {2, false}), (Steps{30, 40}));
    EXPECT_EQ(kept_steps(Steps{10, 20, 30, 40}, {0, false}), Steps{40});
    // Ages 0, 10 are the newest; then the oldest of at most twice 10, of at most twice 20, and so on.
    EXPECT_EQ(kept_steps(Steps{10, 20, 30, 40, 50, 60, 70, 80, 90, 100}, {2, true}), (Steps{10, 20, 60, 80, 90, 100}));
}

/// As a run does it: each checkpoint thins what the ones before have left.
TEST(Keeping, leaves_milestones_at_doubling_ages_however_checkpoints_come) {
    std::mt19937_64 engine(5);
    for (const std::int64_t newest : {1, 2, 5})
        for (const bool even : {true, false}) {
            Steps kept, all;
            std::int64_t step = 0;
            for (int n = 1; n <= 3000; ++n) {
                step += even ? 10 : 1 + static_cast<std::int64_t>(engine() % 1000);
                all.push_back(step);
                kept.push_back(step);
                kept = kept_steps(kept, {newest, true});
                ASSERT_TRUE(std::is_sorted(kept.begin(), kept.end()));
                ASSERT_EQ(kept.front(), all.front());
                const auto last = std::min<std::size_t>(static_cast<std::size_t>(newest), all.size());
                ASSERT_TRUE(std::equal(kept.end() - static_cast<std::ptrdiff_t>(last), kept.end(),
                                       all.end() - static_cast<std::ptrdiff_t>(last)));
                if (n % 100 != 0) continue;
                for (const std::int64_t s : all) { // one at most twice as old
                    const auto at = std::upper_bound(kept.begin(), kept.end(), s) - 1;
                    EXPECT_LE(step - *at, 2 * (step - s)) << s << " of " << step;
                }
                if (even) {
                    EXPECT_LE(static_cast<double>(kept.size()), static_cast<double>(newest) + 2 * std::log2(n) + 1);
                }
            }
        }
}

TEST(Keeping, of_a_month_are_about_two_dozen) {
    Steps kept;
    for (std::int64_t n = 1; n <= 30 * 24 * 4; ++n) {
        kept.push_back(1000 * n);
        kept = kept_steps(kept, {2, true});
    }
    EXPECT_LE(kept.size(), 24u);
    EXPECT_GE(kept.size(), 12u);
}

} // namespace
} // namespace skein
