// Memory of joints in states at rest: whole turns after corrections, and anchors of dry friction after load steps.
#include "equilibrium/newton.hpp"
#include "scene/scene_file.hpp"
#include "studies/scene_family.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>

namespace skein {
namespace {

/// A body that turns about its first axis in place, by a joint with these keys.
std::unique_ptr<StaticCase> wheel(const std::string& keys) {
    return static_case({"wheel.toml",
                        fmt::format(R"toml(
time.duration = 1.0
[[bodies]]
name = "wheel"
mass = 1.0
inertia = [0.01, 0.01, 0.01]
spheres.radii = [0.05]
placement = {{origin = [0.0, 0.0, 0.0], tangent = [0.0, 0.0, 1.0], normal = [1.0, 0.0, 0.0]}}
[[joint]]
between = ["wheel", "world"]
place = [0.0, 0.0, 0.0]
stiffness = 1e4
{}
)toml",
                                    keys),
                        {}},
                       {}, 1);
}
const std::string hinge = "kind = \"hinge\"\naxis = [1.0, 0.0, 0.0]\ntorsional_stiffness = 1e3\n";

class Wheel {
public:
    explicit Wheel(const std::string& keys) : one(wheel(keys)), system(*one->system) {
        state = start_of(system, one->groups, one->rods);
        system.keep_joints(state);
    }
    void turn(double angle, double share = 1) {
        Unknown correction = Unknown::Zero(system.unknowns());
        correction[3] = angle;
        system.correct(state, correction, share);
    }
    double couple() { return couple_at(state); }
    double couple_at(const StaticState& at) { return system.balance(at, false).residual[3]; }
    double stiffness() { return system.balance(state, true).stiffness->coeff(3, 3); }

    std::unique_ptr<StaticCase> one;
    StaticSystem& system;
    StaticState state;
};

TEST(TurningJoints, CountWholeTurnsFromCorrectionToCorrection) {
    const std::string universal = "kind = \"universal\"\naxis = [1.0, 0.0, 0.0]\nsecond_axis = [0.0, 1.0, 0.0]\n"
                                  "torsional_stiffness = 1e3\nspring = 2.0";
    for (const std::string& keys : {hinge + "spring = 2.0", universal}) {
        Wheel wheel(keys);
        double angle = 0;
        for (const double by : {1.0, 2.0, 3.0, 1.5, 2.5, 3.0, -1.0, -3.0, -3.0, -3.0, -3.0, -2.0, -1.0, 0.25}) {
            wheel.turn(2 * by, 0.5);
            angle += by;
            EXPECT_NEAR(wheel.couple(), -2 * angle, 1e-11) << keys << " at " << angle;
            EXPECT_NEAR(wheel.stiffness(), 2, 1e-11) << keys << " at " << angle;
        }
    }
}

TEST(TurningJoints, ReachMotorsBeyondATurn) {
    Wheel wheel(hinge + "motor = {kind = \"position\", value = \"14*t\", stiffness = 5.0, damping = 7.0}");
    EXPECT_EQ(wheel.system.at_rest().turning_motors(), 1U);
    wheel.system.set_time(1); // 14 rad, and a rate that does not act at rest
    for (int i = 0; i < 7; ++i) wheel.turn(2);
    EXPECT_NEAR(wheel.couple(), 0, 1e-11);
    wheel.turn(-2.5);
    EXPECT_NEAR(wheel.couple(), 12.5, 1e-11);
    EXPECT_LE(14 * wheel.system.lead_up_to(0.25, 1, 1.5), 0.25 * 14 + 1.5);
    EXPECT_GE(14 * wheel.system.lead_up_to(0.25, 1, 1.5), 0.25 * 14 + 1.4);
}

TEST(TurningJoints, HaveTheirTurnsAgainAfterAStepThatFailed) {
    Wheel wheel(hinge + "spring = 2.0");
    for (int i = 0; i < 4; ++i) wheel.turn(2);
    const StaticState good = wheel.state;
    const double before = wheel.couple();
    EXPECT_NEAR(before, -16, 1e-11);
    for (int i = 0; i < 5; ++i) wheel.turn(2);
    EXPECT_NEAR(wheel.couple(), -36, 1e-11);
    EXPECT_EQ(wheel.couple_at(good), before) << "loads of a state do not depend on those that were looked at before";
    wheel.state = good;
    wheel.turn(-2);
    EXPECT_NEAR(wheel.couple(), -12, 1e-11);
}

TEST(TurningJoints, HoldByFrictionThatSlipsAfterLoadSteps) {
    const double spring = 20, limit = 0.5, holding = 400;
    Wheel wheel(hinge + "spring = 20.0\nfriction = 0.5\nfriction_stiffness = 400.0");
    wheel.turn(1e-3);
    EXPECT_NEAR(wheel.couple(), -spring * 1e-3, 1e-12) << "friction is left out until a reference is set";
    wheel.turn(-1e-3);
    wheel.system.set_reference(wheel.state);
    wheel.turn(1e-3);
    EXPECT_NEAR(wheel.couple(), -(spring + holding) * 1e-3, 1e-12);
    EXPECT_NEAR(wheel.stiffness(), spring + holding, 1e-9);
    const StaticState held = wheel.state;
    wheel.turn(99e-3);
    EXPECT_NEAR(wheel.couple(), -(spring * 0.1 + limit), 1e-12);
    EXPECT_NEAR(wheel.stiffness(), spring, 1e-9);
    wheel.turn(-99e-3);
    EXPECT_NEAR(wheel.couple(), -(spring + holding) * 1e-3, 1e-12) << "nothing slips within a load step";
    wheel.turn(99e-3);
    wheel.system.keep_joints(wheel.state);
    wheel.turn(-5e-4);
    EXPECT_NEAR(wheel.couple(), -(spring * 0.0995 + limit - holding * 5e-4), 1e-8);
    EXPECT_NEAR(wheel.couple_at(held), -(spring + holding) * 1e-3, 1e-12) << "a step that failed slipped nothing";
}

TEST(TurningJoints, HoldTheTurnOfABall) {
    Wheel wheel("kind = \"spherical\"\nfriction = 0.5\nfriction_stiffness = 400.0\n");
    wheel.system.set_reference(wheel.state);
    wheel.turn(1e-3);
    EXPECT_NEAR(wheel.couple(), -0.4, 1e-12);
    wheel.turn(1.0);
    EXPECT_NEAR(wheel.couple(), -0.5, 1e-12);
    wheel.system.keep_joints(wheel.state);
    EXPECT_NEAR(wheel.couple(), -0.5, 1e-12);
    wheel.turn(-1e-3);
    EXPECT_NEAR(wheel.couple(), -0.1, 1e-10);
}

} // namespace
} // namespace skein
