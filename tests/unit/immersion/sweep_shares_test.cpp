// What sweeps with shares leave of a slip, by how much of it one sweep takes away.
#include "immersion/sweep_shares.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace skein {
namespace {

/// Of n sweeps together, over what the first one does.
double together(int n, double taken) {
    double sum = 0, left = 1;
    for (const double share : sweep_shares(n)) {
        sum += share * left;
        left *= 1 - taken;
    }
    return sum;
}
double left_by(int n, double taken) { return 1 - taken * together(n, taken); }

TEST(SweepShares, UpToThreeSweepsGoAsTheyAre) {
    for (int n = 1; n <= 3; ++n)
        for (const double share : sweep_shares(n)) EXPECT_EQ(share, 1);
}

TEST(SweepShares, TogetherNoSlipIsChangedByLessThanTheFirstOrMoreThanThreeTimesThat) {
    for (int n = 1; n <= 20; ++n)
        for (int i = 1; i <= 200; ++i) {
            const double all = together(n, i / 200.0);
            EXPECT_GE(all, 1 - 1e-9) << n << " " << i;
            EXPECT_LE(all, 3 + 1e-9) << n << " " << i;
        }
}

TEST(SweepShares, MoreSweepsLeaveNoMoreSlipAndAVelocityThatAllLackVanishes) {
    for (int n = 2; n <= 20; ++n) {
        EXPECT_NEAR(left_by(n, 1), 0, 1e-12);
        for (int i = 1; i <= 200; ++i)
            EXPECT_LE(left_by(n, i / 200.0), left_by(n - 1, i / 200.0) + 1e-9) << n << " " << i;
    }
    EXPECT_LT(left_by(20, 0.5), 0.1 * left_by(3, 0.5));
}

} // namespace
} // namespace skein
