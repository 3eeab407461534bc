// What must hold of every kind of joint: it carries no momentum, springs keep energy and dashpots take it, the
// automatic step bears any stiffness, and bits do not depend on lanes, threads or the protocol.
#include "loads/muscle_formula.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "support/joint_examples.hpp"
#include "support/meeting.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {
namespace {

using test::joint_examples;
using test::JointExample;
using test::Meeting;
using test::simple_rod;
using test::stick;

double joint_energy(const Meeting& stage) {
    double sum = 0;
    for (const double energy :
         joints_now(*stage.plan.find<JointPlan>(), stage.groups, *stage.rods, {stage.clock.time(), stage.clock.lag()})
             .energies)
        sum += energy;
    return sum;
}

TEST(Joints, CarryNoMomentum) {
    for (const double damping : {0.0, 5.0})
        for (const JointExample& e : joint_examples(1e4, damping)) {
            Meeting stage(e.scene);
            const test::Momenta before = stage.momenta();
            stage.advance(2000);
            const test::Momenta after = stage.momenta();
            EXPECT_LT(norm(after.linear - before.linear), 1e-13 * norm(before.linear) * 10) << e.name;
            EXPECT_LT(norm(after.angular - before.angular), 1e-12 * (norm(before.angular) + norm(before.linear)))
                << e.name;
        }
}

TEST(Joints, KeepEnergyUnlessTheyAreDamped) {
    for (const double damping : {0.0, 5.0})
        for (const JointExample& e : joint_examples(1e4, damping)) {
            Meeting stage(e.scene);
            const double start = stage.energy() + joint_energy(stage);
            double least = start, most = start;
            for (int part = 0; part < 40; ++part) {
                stage.advance(200);
                const double now = stage.energy() + joint_energy(stage);
                least = std::min(least, now);
                most = std::max(most, now);
            }
            if (damping == 0) EXPECT_LT(most - least, 3e-2 * start) << e.name; // of the step, which is the longest
            else EXPECT_LT(least, 0.999 * start) << e.name;
            EXPECT_LT(most, 1.03 * start) << e.name << ", damping " << damping;
        }
}

TEST(CommonNodes, KeepMomentumEnergyAndPlaces) {
    for (const JointExample& e : test::common_node_examples()) {
        Meeting stage(e.scene);
        const test::Momenta before = stage.momenta();
        stage.advance(8); // the first kick makes one velocity of those of the start
        const double start = stage.energy() + joint_energy(stage);
        double least = start, most = start;
        for (int part = 0; part < 20; ++part) {
            stage.advance(200);
            const double now = stage.energy() + joint_energy(stage);
            least = std::min(least, now);
            most = std::max(most, now);
        }
        const test::Momenta after = stage.momenta();
        std::printf("%s: energy within %.1e, momentum %.1e, angular momentum %.1e, gap %.1e m\n", e.name.c_str(),
                    (most - least) / start, norm(after.linear - before.linear) / norm(before.linear),
                    norm(after.angular - before.angular) / (norm(before.angular) + norm(before.linear)),
                    joints_now(*stage.plan.find<JointPlan>(), stage.groups, *stage.rods,
                               {stage.clock.time(), stage.clock.lag()})
                        .gap);
        EXPECT_LT(most - least, 3e-2 * start) << e.name; // of the step, which is the longest
        EXPECT_LT(norm(after.linear - before.linear), 1e-12 * norm(before.linear)) << e.name;
        const bool body = std::any_of(e.scene.rods.begin(), e.scene.rods.end(),
                                      [](const RodSpec& rod) { return rod.body.has_value(); });
        EXPECT_LT(norm(after.angular - before.angular),
                  (body ? 1e-5 : 1e-12) * (norm(before.angular) + norm(before.linear)))
            << e.name;
    }
}

TEST(CommonNodes, AreRefusedWithACureWhereThereAreNone) {
    const auto refusal = [](const RodSpec& second, std::vector<double> at) -> std::string {
        SceneSpec scene;
        scene.rods = {stick("first", {0, 0, 0}, {1, 0, 0}), second};
        scene.joints = {{.kind = JointKind::fixed, .between = {"first", second.name}, .at = std::move(at)}};
        scene.time.duration = 1;
        try {
            make_plan(scene, make_groups(scene), {1, 1, 1, 1, {}, Mapping::automatic});
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    const RodSpec on = stick("second", {0.8, 0, 0}, {0, 1, 0});
    EXPECT_EQ(refusal(on, {1, 0}), "");
    EXPECT_NE(refusal(stick("second", {0.24, 0, 0}, {0, 1, 0}), {0.3, 0}).find("'at' is at a node, here 0.25 or 0.375"),
              std::string::npos);
    EXPECT_EQ(refusal(stick("second", {0.2, 0, 0}, {0, 1, 0}), {0.25, 0}), ""); // which that cure says
    EXPECT_NE(refusal(stick("second", {0.8, 0, 0.01}, {0, 1, 0}), {1, 0}).find("off the axis"), std::string::npos);
    RodSpec clamped = on;
    clamped.start = EndKind::clamped;
    EXPECT_NE(refusal(clamped, {1, 0}).find("clamp the other rod too"), std::string::npos);
}

TEST(CommonNodes, AreDampedAsTheOthers) {
    SceneSpec scene = test::common_node_examples().front().scene;
    for (RodSpec& rod : scene.rods) {
        rod.shape.velocity = {0, 0, 1};
        rod.shape.angular_velocity = {0, 0, 0};
    }
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 3}}};
    Meeting stage(scene);
    stage.advance(2000);
    const double expected = std::exp(-3 * stage.clock.time());
    for (std::size_t i = 0; i < 2; ++i)
        for (const Slot<1>& s : stage.state(i)) EXPECT_NEAR(lane(s.velocity, 0).z / expected, 1, 1e-5);
}

TEST(Joints, OfAnyStiffnessBearTheAutomaticStep) {
    for (const double stiffness : {1e2, 1e4, 1e6, 1e8, 1e10})
        for (const JointExample& e : joint_examples(stiffness)) {
            Meeting stage(e.scene);
            const double start = stage.energy();
            stage.advance(3000);
            EXPECT_LT(stage.energy(), 1.1 * start) << e.name << ", k = " << stiffness;
        }
}

/// A chain of two rods in copies, some of them turned.
SceneSpec chains(long copies) {
    SceneSpec scene;
    RodSpec first = stick("first", {0, 0, 0}, {1, 0, 0}), second = stick("second", {0.8, 0, 0}, {0.6, 0.8, 0});
    first.assembly = second.assembly = "chain";
    first.shape.velocity = {0, 0, 1};
    scene.rods = {first, second};
    AssemblySpec assembly{.name = "chain"};
    assembly.placement = {.kind = PlacementKind::line, .normal = Vec3d{0, 1, 0}, .counts = {copies}, .spacing = {3}};
    scene.assemblies = {assembly};
    scene.joints = {{.kind = JointKind::fixed,
                     .between = {"first", "second"},
                     .law = {.stiffness = 1e5, .damping = 3, .torsional_stiffness = 50, .torsional_damping = 0.1}}};
    scene.loads = {{.load = make_load(0)}};
    scene.time.duration = 0.05;
    return scene;
}

std::uint64_t digest_of(const SceneSpec& scene, int lanes, int threads, int together) {
    const auto groups = make_groups(scene);
    const Plan plan = make_plan(scene, groups, {1, threads, threads, lanes, {}, Mapping::automatic});
    const Threads team(threads);
    const auto rods = make_rods(plan, groups, test::all_rods(groups), team);
    Clock clock(plan.dt, 0);
    while (clock.done() < 200) {
        const auto steps = clock.next(200, together);
        EXPECT_TRUE(rods->advance(steps, true));
        clock.advance(steps);
    }
    return rods->digest();
}

TEST(Joints, HaveTheSameBitsInAnyLanesAndVisits) {
    for (const long copies : {1L, 2L, 5L, 11L}) {
        const SceneSpec scene = chains(copies);
        const std::uint64_t expected = digest_of(scene, 1, 1, 1);
        for (const int lanes : test::built_lanes())
            for (const int threads : {1, 2})
                EXPECT_EQ(digest_of(scene, lanes, threads, 64), expected) << copies << " copies, " << lanes << " lanes";
    }
}

TEST(CommonNodes, HaveTheSameBitsInAnyLanesAndVisits) {
    for (const JointExample& e : test::common_node_examples())
        for (const long copies : {1L, 3L, 11L}) {
            SceneSpec scene = e.scene;
            for (RodSpec& rod : scene.rods) rod.assembly = "copies";
            AssemblySpec assembly{.name = "copies"};
            assembly.placement = {
                .kind = PlacementKind::line, .normal = Vec3d{0, 1, 0}, .counts = {copies}, .spacing = {3}};
            scene.assemblies = {assembly};
            scene.loads = {
                {.load = MuscleFormula{.moment = {"0.1 * s * rod", "0.2", "0"}}, .rods = {scene.rods[0].name}}};
            scene.time.duration = 0.05;
            const std::uint64_t expected = digest_of(scene, 1, 1, 1);
            for (const int lanes : test::built_lanes({2, 4, 8}))
                for (const int threads : {1, 2})
                    EXPECT_EQ(digest_of(scene, lanes, threads, 64), expected)
                        << e.name << ", " << copies << " copies, " << lanes << " lanes";
        }
}

TEST(Joints, MoveCopiesThatAreAlikeAlike) {
    SceneSpec scene = chains(11);
    scene.assemblies[0].placement = {.kind = PlacementKind::list,
                                     .origins = std::vector<Vec3d>(11, Vec3d{0.1, 0.2, 0.3})};
    Meeting stage(scene, 8);
    stage.advance(300);
    for (std::size_t i = 1; i < stage.rods->local().size(); ++i) {
        if (stage.rods->local()[i].group != stage.rods->local()[i - 1].group) continue;
        const auto a = stage.state(i - 1), b = stage.state(i);
        for (std::size_t k = 0; k < a.size(); ++k)
            EXPECT_EQ(norm(lane(a[k].position, 0) - lane(b[k].position, 0)), 0) << i;
    }
}

// Two thin stiff rods hang by a pin and a joint: angles after a fall obey the equations of two rigid rods.
std::array<double, 4> double_pendulum(double time, double length, double radius, double g) {
    std::array<double, 4> y{0, 0, 0, 0}; // angles from the horizontal, down, and rates
    const int steps = 20000;
    const double h = time / steps;
    const auto rate = [&](const std::array<double, 4>& s) {
        // M (a1, a2) = f of two uniform rods of length l; angles from the vertical are pi/2 - s.
        const double t1 = std::numbers::pi / 2 - s[0], t2 = std::numbers::pi / 2 - s[1], w1 = -s[2], w2 = -s[3],
                     c = std::cos(t1 - t2), sine = std::sin(t1 - t2);
        const double f1 = -0.5 * sine * w2 * w2 - 1.5 * g / length * std::sin(t1),
                     f2 = 0.5 * sine * w1 * w1 - 0.5 * g / length * std::sin(t2);
        const double thick = radius * radius / (4 * length * length), m11 = 4.0 / 3 + thick, m12 = 0.5 * c,
                     m22 = 1.0 / 3 + thick, det = m11 * m22 - m12 * m12;
        return std::array<double, 4>{s[2], s[3], -(m22 * f1 - m12 * f2) / det, -(m11 * f2 - m12 * f1) / det};
    };
    const auto moved = [](const std::array<double, 4>& s, double by, const std::array<double, 4>& r) {
        return std::array<double, 4>{s[0] + by * r[0], s[1] + by * r[1], s[2] + by * r[2], s[3] + by * r[3]};
    };
    for (int i = 0; i < steps; ++i) {
        const auto k1 = rate(y), k2 = rate(moved(y, h / 2, k1)), k3 = rate(moved(y, h / 2, k2)),
                   k4 = rate(moved(y, h, k3));
        for (std::size_t j = 0; j < 4; ++j) y[j] += h / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j]);
    }
    return y;
}

TEST(Joints, LetADoublePendulumFall) {
    constexpr double length = 1, radius = 0.05, g = 9.81, time = 0.5;
    const auto expected = double_pendulum(time, length, radius, g);
    const Vec3d joint{std::cos(expected[0]), 0, -std::sin(expected[0])};
    const Vec3d end = joint + Vec3d{std::cos(expected[1]), 0, -std::sin(expected[1])};
    const auto error = [&](long elements) {
        SceneSpec scene;
        RodSpec upper = simple_rod(static_cast<int>(elements));
        upper.shape.length = length;
        upper.shape.elements = elements;
        upper.section.radius = radius;
        upper.material.youngs_modulus = 4e9;
        upper.material.density = 1000;
        upper.placement.tangent = {1, 0, 0};
        upper.name = "upper";
        upper.start = EndKind::pinned;
        RodSpec lower = upper;
        lower.name = "lower";
        lower.start = EndKind::free;
        lower.placement.origin = {length, 0, 0};
        scene.rods = {upper, lower};
        scene.joints = {{.kind = JointKind::spherical, .between = {"upper", "lower"}, .law = {.stiffness = 1e7}}};
        scene.loads = {{.load = make_load(0)}};
        scene.time.duration = time;
        Meeting stage(scene);
        stage.advance(stage.plan.steps);
        const auto tip = stage.state(1).back();
        return norm(lane(tip.position, 0) - end);
    };
    const double coarse = error(8), fine = error(16);
    EXPECT_LT(fine, 3e-3);
    EXPECT_GT(std::log2(coarse / fine), 1.8) << coarse << " " << fine;
}

} // namespace
} // namespace skein
