// Held ends that slide in some lab directions: what must hold of every kind of end, in every set of directions.
// theory.md (47a)
#include "loads/gravity.hpp"
#include "rod/time_limits.hpp"
#include "scene/make_groups.hpp"
#include "skein/core/index.hpp"
#include "support/energy.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

struct Case {
    EndKind start, end;
    std::string start_free, end_free;
};

std::string text(const Case& c) {
    const auto name = [](EndKind kind) { return std::string(nth(end_names, kind)); };
    return name(c.start) + " [" + c.start_free + "] / " + name(c.end) + " [" + c.end_free + "]";
}

std::vector<EndKind> held_ends() {
    std::vector<EndKind> kinds;
    for (std::size_t i = 0; i < std::size(end_names); ++i)
        if (static_cast<EndKind>(i) != EndKind::free) kinds.push_back(static_cast<EndKind>(i));
    return kinds;
}

/// Each kind of end in each set of directions: against a clamp, alone, and at both ends.
std::vector<Case> all_cases() {
    std::vector<Case> cases;
    for (const EndKind kind : held_ends())
        for (const char* free : {"x", "y", "z", "xy", "xz", "yz", "xyz"}) {
            if (kind == EndKind::pinned && std::string(free) == "xyz") continue;
            cases.push_back({EndKind::clamped, kind, "", free});
            cases.push_back({kind, EndKind::free, free, ""});
            cases.push_back({kind, EndKind::pinned, free, "xz"});
        }
    return cases;
}

/// A rod of everything, on a slant, its curvature off the one at rest: it moves by itself, with all of its nodes.
RodSpec rod_of(const Case& c) {
    RodSpec rod = test::crooked_rod(8);
    rod.start = c.start;
    rod.end = c.end;
    rod.start_free = c.start_free;
    rod.end_free = c.end_free;
    rod.placement.tangent = {0.3, -0.2, 1};
    rod.placement.normal = Vec3d{1, 0.1, 0.2};
    return rod;
}

SceneSpec scene_of(const RodSpec& rod, double share) {
    SceneSpec scene;
    scene.rods = {rod};
    scene.time = {.duration = 100};
    scene.time.dt = share * time_limits(make_groups(scene)[0]).front().dt;
    return scene;
}

RodSpec moving_rod(const Case& c) {
    RodSpec rod = rod_of(c);
    rod.shape.start_curvature = Vec3d{1.2, -0.5, 0.9};
    rod.shape.velocity = {0.1, -0.05, 0.07};
    return rod;
}

double component(const Vec3d& a, char axis) { return axis == 'x' ? a.x : axis == 'y' ? a.y : a.z; }
bool names(const std::string& letters, char axis) { return letters.find(axis) != std::string::npos; }

TEST(Slide, KeepsTheEnergyToTheSquareOfTheStep) {
    for (const Case& c : all_cases()) {
        double drift[2];
        for (const int halved : {0, 1}) {
            test::Stage stage(scene_of(moving_rod(c), halved ? 0.1 : 0.2), 1);
            test::Cost cost;
            drift[halved] = test::energy_drift(stage, halved ? 800 : 400, 100, cost);
        }
        EXPECT_NEAR(drift[0] / drift[1], 4, 0.3) << text(c) << ": " << drift[0];
    }
}

// A direction in which no end is held has no force from outside, a clamp's couple notwithstanding.
TEST(Slide, KeepsTheMomentumOfDirectionsInWhichBothEndsAreFree) {
    int found = 0;
    for (const Case& c : all_cases())
        for (const char axis : {'x', 'y', 'z'}) {
            if (!names(c.start_free, axis) || !(c.end == EndKind::free || names(c.end_free, axis))) continue;
            test::Stage stage(scene_of(moving_rod(c), 0.5), 1);
            const RodGroup& group = stage.groups[0];
            double size = 0;
            const auto start = stage.state(0);
            for (std::size_t i = 0; i < start.size(); ++i)
                size += group.node_mass[i] * norm(lane(start[i].velocity, 0));
            stage.advance(1000);
            const double change =
                component(test::momenta(group, stage.state(0)).linear - test::momenta(group, start).linear, axis);
            EXPECT_LT(std::abs(change), 1e-12 * size) << text(c) << " along " << axis;
            ++found;
        }
    EXPECT_GT(found, 20);
}

TEST(Slide, HoldsTheOtherDirectionsExactlyAndMovesInThese) {
    for (const Case& c : all_cases()) {
        test::Stage stage(scene_of(moving_rod(c), 0.5), 1);
        const auto start = stage.state(0);
        stage.advance(300);
        const auto state = stage.state(0);
        const auto look = [&](std::size_t i, EndKind kind, const std::string& free) {
            if (kind == EndKind::free) return;
            const Vec3d moved = lane(state[i].position, 0) - lane(start[i].position, 0), v = lane(state[i].velocity, 0);
            for (const char axis : {'x', 'y', 'z'}) {
                EXPECT_EQ(component(moved, axis) != 0, names(free, axis))
                    << text(c) << ", node " << i << " along " << axis;
                EXPECT_EQ(component(v, axis) != 0, names(free, axis)) << text(c) << ", node " << i << " along " << axis;
            }
        };
        look(0, c.start, c.start_free);
        look(state.size() - 1, c.end, c.end_free);
    }
}

TEST(Slide, LeavesRodsAtRest) {
    for (const Case& c : all_cases()) {
        test::Stage stage(scene_of(rod_of(c), 0.5), 1);
        const auto start = stage.state(0);
        stage.advance(300);
        const auto state = stage.state(0);
        for (std::size_t i = 0; i < start.size(); ++i)
            EXPECT_LT(norm(lane(state[i].position, 0) - lane(start[i].position, 0)), 1e-12)
                << text(c) << ", node " << i;
    }
}

TEST(Slide, TurnsWithTheScene) {
    const auto turned = [](const Vec3d& a) { return Vec3d{-a.y, a.x, a.z}; };
    const auto turned_axes = [](std::string letters) {
        for (char& l : letters) l = l == 'x' ? 'y' : l == 'y' ? 'x' : l;
        return letters;
    };
    for (const Case& c : all_cases()) {
        SceneSpec scene = scene_of(moving_rod(c), 0.5);
        scene.loads = {{.load = Gravity{.acceleration = {1, -2, -5}}}};
        SceneSpec other = scene;
        RodSpec& rod = other.rods[0];
        rod.placement.tangent = turned(rod.placement.tangent);
        rod.placement.normal = turned(*rod.placement.normal);
        rod.shape.velocity = turned(rod.shape.velocity);
        rod.start_free = turned_axes(c.start_free);
        rod.end_free = turned_axes(c.end_free);
        other.loads = {{.load = Gravity{.acceleration = turned({1, -2, -5})}}};
        test::Stage one(scene, 1), two(other, 1);
        one.advance(300);
        two.advance(300);
        const auto a = one.state(0), b = two.state(0);
        for (std::size_t i = 0; i < a.size(); ++i)
            EXPECT_LT(norm(turned(lane(a[i].position, 0)) - lane(b[i].position, 0)), 1e-11)
                << text(c) << ", node " << i;
    }
}

// Holding a node in some directions only takes freedom away: the bound on the step is what it is for rods with free
// ends.
TEST(Slide, LeavesTheLimitOfTheStep) {
    for (const double radius : {0.004, 0.1})
        for (const Case& c : all_cases()) {
            RodSpec rod = test::simple_rod(8);
            rod.section.radius = radius;
            rod.start = c.start;
            rod.end = c.end;
            rod.start_free = c.start_free;
            rod.end_free = c.end_free;
            test::Stage stage(scene_of(rod, 0.98), 1);
            const RodGroup& group = stage.groups[0];
            auto state = stage.state(0);
            const auto jolt = test::shaken_state(group, 0, 0, 1e-9, 3);
            for (std::size_t i = 1; i + 1 < state.size(); ++i)
                if (!group.holds_element(static_cast<int>(i))) state[i] = jolt[i];
            stage.rods->import_rod(0, state);
            const double before = test::energy(group, state);
            stage.advance(3000);
            EXPECT_LT(test::energy(group, stage.state(0)), 50 * before) << text(c) << ", radius " << radius;
        }
}

TEST(Slide, IsAPassOfRodsThatNeedIt) {
    const auto passes = [](const Case& c) { return test::Stage(scene_of(rod_of(c), 0.5), 1).plan.groups[0]; };
    const GroupPlan none = passes({EndKind::clamped, EndKind::pinned, "", ""}),
                    some = passes({EndKind::clamped, EndKind::pinned, "", "xz"});
    EXPECT_EQ(some.program.size(), none.program.size() + 1);
    EXPECT_GE(some.family, 0) << "may lie along";
    EXPECT_EQ(passes({EndKind::clamped, EndKind::clamped, "", "z"}).family, -1) << "lies across";
    EXPECT_EQ(some.program.names().back(), "slide");
    EXPECT_EQ(some.start, "clamped");
    EXPECT_EQ(some.end, "pinned, free along xz");
}

} // namespace
} // namespace skein
