// Cadences against counting, and stages of a coupled step against their shares of it.
#include "skein/time/clock.hpp"
#include "time/coupling_schedule.hpp"
#include "time/every.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace skein {
namespace {

TEST(Every, FallsOnMultiples) {
    const Every five{5};
    for (std::int64_t step = 0; step < 23; ++step) {
        EXPECT_EQ(five.due(step), step == 0 || step == 5 || step == 10 || step == 15 || step == 20) << step;
        std::int64_t next = step + 1, from = step, last = step;
        while (next % 5 != 0) ++next;
        while (from % 5 != 0) ++from;
        while (last % 5 != 0) --last;
        EXPECT_EQ(five.next(step), next);
        EXPECT_EQ(five.from(step), from);
        EXPECT_EQ(five.last(step), last);
    }
}

TEST(Every, IsNeverDueWithoutAnInterval) {
    EXPECT_FALSE(Every{}.due(0));
    EXPECT_EQ(Every{}.next(7), Every::never);
}

/// Stages of a third-order step: eight fifteenths, two and five.
constexpr std::array<int, 3> shares{8, 2, 5};

TEST(CouplingSchedule, CutsAnIntervalIntoPartsWhoseStagesFollowTheirShares) {
    CouplingSchedule schedule(120, shares); // eight units of 15 steps
    std::vector<std::int64_t> begins, ends;
    for (std::int64_t done = 0; done < 240; ++done) {
        if (schedule.part_begins(done)) {
            EXPECT_EQ(schedule.units_left(done), (120 - done % 120) / 15) << done;
            schedule.begin_part(done, done % 120 == 0 ? 2 : 3); // 30, 45 and 45 steps
        }
        if (const auto stage = schedule.stage_begins(done)) begins.push_back(1000 * *stage + done);
        const std::int64_t next = schedule.part_begins(done) ? done + 1 : schedule.next(done);
        const auto stage = schedule.stage_ends(done + 1);
        EXPECT_TRUE(!stage || schedule.part_begins(done) || next == done + 1) << done;
        if (stage) ends.push_back(1000 * *stage + done + 1);
    }
    EXPECT_EQ(begins, (std::vector<std::int64_t>{0, 1016, 2020, 30, 1054, 2060, 75, 1099, 2105, //
                                                 120, 1136, 2140, 150, 1174, 2180, 195, 1219, 2225}));
    EXPECT_EQ(ends, (std::vector<std::int64_t>{16, 1020, 2030, 54, 1060, 2075, 99, 1105, 2120, //
                                               136, 1140, 2150, 174, 1180, 2195, 219, 1225, 2240}));
}

TEST(CouplingSchedule, GoesFromTheEndOfAStageToTheNext) {
    CouplingSchedule schedule(60, shares);
    std::vector<std::int64_t> visited;
    for (std::int64_t done = 0; done < 60;) {
        if (schedule.part_begins(done)) {
            EXPECT_EQ(schedule.next(done), done + 1); // its length is not chosen yet
            schedule.begin_part(done, 2);
            done = done + 1;
        } else {
            done = schedule.next(done);
        }
        visited.push_back(done);
    }
    EXPECT_EQ(visited, (std::vector<std::int64_t>{1, 16, 20, 30, 31, 46, 50, 60}));
}

TEST(CouplingSchedule, OneLongerStepGoesThroughAStage) {
    CouplingSchedule schedule(60, shares);
    std::vector<std::int64_t> visited;
    for (std::int64_t done = 0; done < 60; visited.push_back(done)) {
        if (schedule.part_begins(done)) schedule.begin_part(done, 2);
        EXPECT_TRUE(schedule.stage_begins(done)) << done;
        done = schedule.end_of_stage(done);
        EXPECT_TRUE(schedule.stage_ends(done)) << done;
    }
    EXPECT_EQ(visited, (std::vector<std::int64_t>{16, 20, 30, 46, 50, 60}));
}

TEST(Clock, MakesSeveralStepsAsOneInParts) {
    Clock clock(0.5, 4, Integrator::implicit_damped);
    const std::span<const Step> steps = clock.next_in_parts(2, 0, Clock::largest_batch, 3);
    ASSERT_EQ(steps.size(), 4U);
    for (const Step& step : steps) {
        EXPECT_EQ(step.index, 7);
        EXPECT_DOUBLE_EQ(step.dt, 0.75);
        EXPECT_EQ(step.first_stage, step.drift > 0);
        EXPECT_EQ(step.last_stage, step.drift == 0);
        EXPECT_EQ(step.completes, &step == &steps.back());
    }
    EXPECT_DOUBLE_EQ(steps.front().begin, 2.0);
    EXPECT_DOUBLE_EQ(steps.back().end(), 3.5);
    const Step whole = clock.next_whole(7).back();
    EXPECT_DOUBLE_EQ(whole.end(), 3.5);
    EXPECT_TRUE(whole.completes);
}

TEST(CouplingSchedule, OfOneStageEndsWithItsPart) {
    CouplingSchedule schedule(12, std::array{1});
    schedule.begin_part(0, 4);
    EXPECT_EQ(schedule.stage_begins(0), std::optional(0));
    EXPECT_EQ(schedule.stage_ends(4), std::optional(0));
    EXPECT_FALSE(schedule.stage_ends(3));
    EXPECT_TRUE(schedule.part_begins(4));
    EXPECT_FALSE(schedule.interval_begins(4));
    EXPECT_EQ(schedule.units_left(4), 8);
    EXPECT_EQ(schedule.shares_before(1) - schedule.shares_before(0), 1);
}

} // namespace
} // namespace skein
