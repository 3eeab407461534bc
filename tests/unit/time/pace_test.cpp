// Parts of a step by the pace of what moves: they fill the step exactly, are no longer than the pace allows, and no
// shorter than they need be.
#include "time/step_control.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace skein {
namespace {

constexpr double dt = 0.1, allowed = 1e-3;

/// Parts of a step in which the speed is that of the time, as shares of the step.
template <class Speed> std::vector<double> parts_of(PaceControl& pace, Speed&& speed) {
    std::vector<double> parts;
    double begin = 0;
    for (pace.begin(); !pace.ended(); pace.next()) {
        EXPECT_TRUE(pace.choose(speed(begin), dt));
        EXPECT_DOUBLE_EQ(begin, static_cast<double>(pace.part()) / static_cast<double>(pace.parts()));
        parts.push_back(1.0 / static_cast<double>(pace.parts()));
        begin += parts.back();
    }
    EXPECT_EQ(begin, 1.0);
    return parts;
}

TEST(PaceControl, LeavesSlowStepsWhole) {
    PaceControl pace(allowed);
    EXPECT_EQ(parts_of(pace, [](double) { return allowed / dt; }).size(), 1u);
    EXPECT_EQ(parts_of(pace, [](double) { return 1.001 * allowed / dt; }).size(), 2u);
    EXPECT_EQ(pace.most(), 2);
    EXPECT_EQ(pace.made(), 3);
}

TEST(PaceControl, FollowsTheSpeedWithinAStep) {
    PaceControl pace(allowed);
    const auto speed = [](double time) { return allowed / dt * (time < 0.4 ? 4 : time < 0.6 ? 30 : 3); };
    double begin = 0;
    for (const double part : parts_of(pace, speed)) {
        EXPECT_LE(part * dt * speed(begin), allowed);
        const bool could_be_longer = 2 * part * dt * speed(begin) <= allowed && std::fmod(begin, 2 * part) == 0;
        EXPECT_FALSE(could_be_longer && part < 1) << begin;
        begin += part;
    }
    EXPECT_EQ(pace.most(), 32);
}

TEST(PaceControl, EndsWhereNoPartIsShortEnough) {
    PaceControl pace(allowed);
    pace.begin();
    EXPECT_FALSE(pace.choose(1e12, dt));
    EXPECT_FALSE(pace.choose(HUGE_VAL, dt));
}

} // namespace
} // namespace skein
