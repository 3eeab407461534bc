// A lid that compresses a bed between two stresses; boxes and steady walls.
#include "contact/servo.hpp"

#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

namespace skein {
namespace {

Wall lid() {
    Wall wall;
    wall.name = "lid";
    wall.point = {0, 0, 0.093};
    wall.normal = {0, 0, -1};
    wall.from = 1;
    wall.servo = {.speed = 5e-3,
                  .watch = "floor",
                  .area = 0.01,
                  .turn_back_above = 1091,
                  .turn_forth_below = 121,
                  .not_before = 0.078,
                  .cycles = 3};
    return wall;
}

/// The bed of the test: springy below 70 mm, with the weight of its rods on the floor.
double base_force(double height) { return 0.91 + 1e4 * std::max(0.0, 0.07 - height); }

TEST(Servo, CyclesBetweenTwoStresses) {
    Servo servo(lid());
    const double h = 1e-3;
    double lowest = 1, highest = 0;
    for (int step = 0; step < 1000; ++step) servo.step(base_force(servo.height()), servo.height() < 0.07, h);
    EXPECT_EQ(servo.offset(), 0) << "not before its time";
    EXPECT_EQ(servo.direction(), 0);
    for (int step = 0; step < 30000 && !servo.finished(); ++step) {
        servo.step(base_force(servo.height()), servo.height() < 0.07, h);
        if (servo.turns() == 1) {
            EXPECT_EQ(servo.wall_state().velocity.z, 5e-3) << "up";
        }
        if (servo.turns() > 0) {
            lowest = std::min(lowest, servo.height());
            highest = std::max(highest, servo.height());
        }
    }
    EXPECT_TRUE(servo.finished());
    EXPECT_EQ(servo.turns(), 6);
    EXPECT_EQ(servo.direction(), 0);
    // (1091 Pa - 91 Pa) 0.01 m^2 / 1e4 N/m = 1 mm into the bed; up to 78 mm, where the stress has long been low. A step
    // is 5e-6 m.
    EXPECT_NEAR(lowest, 0.069, 1e-5);
    EXPECT_NEAR(highest, 0.078, 1e-5);
    ASSERT_EQ(servo.turned_at().size(), 6u);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(servo.turned_at()[i], i % 2 ? 0.015 : 0.024, 1e-5) << i;
    EXPECT_NEAR(servo.wall_state().offset.z, -0.015, 1e-5);
    EXPECT_EQ(servo.wall_state().velocity.z, 0);
    const double at = servo.offset();
    servo.step(0, false, h);
    EXPECT_EQ(servo.offset(), at);
}

TEST(Servo, WaitsForReliefBeyondItsHeight) {
    Wall wall = lid();
    wall.from = 0;
    wall.servo.not_before = 0.05; // reached long before the stress has fallen
    Servo servo(wall);
    for (int step = 0; step < 20000 && servo.turns() < 2; ++step)
        servo.step(base_force(servo.height()), servo.height() < 0.07, 1e-3);
    ASSERT_EQ(servo.turns(), 2);
    EXPECT_NEAR(servo.height(), 0.07 - 0.3e-4, 1e-5) << "30 Pa above the weight";
}

// Not at a stress that passes, as of a bed that still swings.
TEST(Servo, ApproachesUntilItTouchesOrIsThere) {
    for (const double approach_to : {0.0, 0.08}) {
        Wall wall = lid();
        wall.from = 0;
        wall.servo.approach = 0.05;
        wall.servo.approach_to = approach_to;
        Servo servo(wall);
        for (int step = 0; step < 3000 && servo.turns() == 0; ++step) {
            const bool touched = servo.height() < 0.07, there = servo.height() <= approach_to;
            servo.step(step == 5 ? 900 * wall.servo.area : base_force(servo.height()), touched, 1e-3);
            EXPECT_EQ(norm(servo.wall_state().velocity), touched || there || servo.height() < 0.07 - 1e-4 ? 5e-3 : 0.05)
                << servo.height();
        }
        EXPECT_EQ(servo.turns(), 1);
    }
}

TEST(Servo, GoesOnFromItsState) {
    Servo whole(lid()), first(lid()), second(lid());
    const auto advance = [](Servo& servo, int steps) {
        for (int step = 0; step < steps; ++step) servo.step(base_force(servo.height()), servo.height() < 0.07, 1e-3);
    };
    advance(whole, 12000);
    advance(first, 7000);
    ASSERT_GT(first.turns(), 0);
    second.restore(first.state());
    advance(second, 5000);
    EXPECT_EQ(second.state(), whole.state());
}

TEST(Walls, OfABoxFaceInwards) {
    Wall box;
    box.name = "box";
    box.kind = WallKind::box;
    box.lower = {-1, -2, -3};
    box.upper = {1, 2, 3};
    box.open = {"z+"};
    box.law.stiffness = 7;
    const Walls walls({box});
    ASSERT_EQ(walls.count(), 5u);
    EXPECT_EQ(walls.find("box z+"), -1);
    for (const Wall& plane : walls.wall) {
        EXPECT_EQ(plane.kind, WallKind::plane);
        EXPECT_EQ(plane.law.stiffness, 7);
        EXPECT_LT(dot(plane.normal, plane.point), 0) << "the origin is inside";
    }
    const Wall& right = nth(walls.wall, walls.find("box y+"));
    EXPECT_EQ(right.point.y, 2);
    EXPECT_EQ(right.normal.y, -1);
}

TEST(Walls, ThatMoveFollowTime) {
    Wall piston;
    piston.name = "piston";
    piston.velocity = {0, 0, -2};
    piston.from = 0.5;
    const Walls walls({piston});
    EXPECT_EQ(walls.at(0, 0.4).offset.z, 0);
    EXPECT_EQ(walls.at(0, 0.4).velocity.z, 0);
    EXPECT_EQ(walls.at(0, 0.75).offset.z, -0.5);
    EXPECT_EQ(walls.at(0, 0.75).velocity.z, -2);
}

TEST(Walls, ThatMakeNoSenseAreRefused) {
    Wall good;
    good.name = "a";
    const auto refused = [](const std::vector<Wall>& walls) { EXPECT_THROW(expanded(walls), InputError); };
    EXPECT_NO_THROW(expanded({good}));
    refused({good, good});
    Wall bad = good;
    bad.normal = {0, 0, 0};
    refused({bad});
    bad = good;
    bad.kind = WallKind::tube;
    refused({bad});
    bad.kind = WallKind::box;
    refused({bad});
    bad.upper = {1, 1, 1};
    bad.open = {"up"};
    refused({bad});
    bad = lid();
    refused({bad});
    bad.servo.watch = "a";
    EXPECT_NO_THROW(expanded({good, bad}));
}

} // namespace
} // namespace skein
