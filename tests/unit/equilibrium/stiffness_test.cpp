// Stiffness of everything that acts at rest: every law, end, load, joint and wall, against central differences of the
// loads, and symmetric where the loads have a potential. The second derivative is that along t -> R(t) Q: a couple c at
// t has the components c + t x c/2 there.
#include "equilibrium/static_system.hpp"
#include "kernels/kernels.hpp"
#include "physics/walls/wall_plan.hpp"
#include "support/interaction_examples.hpp"
#include "support/joint_examples.hpp"
#include "support/load_examples.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace skein {
namespace {

/// Bodies of a scene at rest, in states near its start.
struct Bodies {
    SceneSpec scene;
    std::vector<RodGroup> groups;
    Plan plan;
    std::vector<LocalRod> rods;
    StaticSystem system;

    explicit Bodies(SceneSpec s)
        : scene(std::move(s)), groups(make_groups(scene)), plan(make_plan(scene, groups, {})),
          rods(test::all_rods(groups)), system(groups, rods, make_static_rods(plan, groups, rods, walls())) {}

    std::shared_ptr<Walls> walls() const {
        const auto* walls = plan.find<WallPlan>();
        return walls ? std::make_shared<Walls>(walls->walls) : nullptr;
    }
    StaticState start() const {
        StaticState state;
        for (const LocalRod& rod : rods) {
            const RodGroup& group = nth(groups, rod.group);
            std::vector<Slot<1>> one(static_cast<std::size_t>(group.slots()));
            group.start_state(rod.index, one);
            state.slot.insert(state.slot.end(), one.begin(), one.end());
        }
        system.map().gather(state.slot);
        system.refresh(state);
        return state;
    }
    /// All unknowns moved at random by up to `size`, m and rad.
    StaticState disturbed(double size, std::mt19937& random) const {
        StaticState state = start();
        std::uniform_real_distribution<double> some(-size, size);
        Unknown u(system.unknowns());
        for (double& x : u) x = some(random);
        system.correct(state, u, 1);
        system.refresh(state);
        return state;
    }
    /// Residual in the chart of `base`, at the displacement u from there.
    Unknown charted(const StaticState& base, const Unknown& u) {
        StaticState state = base;
        system.correct(state, u, 1);
        system.refresh(state);
        Unknown r = system.balance(state, false).residual;
        for (int i = 0; i + 2 < u.size(); ++i) {
            if (system.map().place(i).i != 3 || system.map().place(i + 2).i != 5) continue;
            const Vec3d t{u[i], u[i + 1], u[i + 2]}, c{r[i], r[i + 1], r[i + 2]}, more = 0.5 * cross(t, c);
            r[i] += more.x;
            r[i + 1] += more.y;
            r[i + 2] += more.z;
        }
        return r;
    }
};

/// Stiffness by differences of fourth order: those of second order lose digits before they are as exact.
Eigen::MatrixXd differences(Bodies& bodies, const StaticState& state, double h) {
    const int count = bodies.system.unknowns();
    Eigen::MatrixXd d(count, count);
    for (int j = 0; j < count; ++j) {
        const Unknown u = h * Unknown::Unit(count, j);
        d.col(j) = (8 * (bodies.charted(state, -u) - bodies.charted(state, u)) -
                    (bodies.charted(state, -2 * u) - bodies.charted(state, 2 * u))) /
                   (12 * h);
    }
    return d;
}

struct Errors {
    double difference = 0, asymmetry = 0, of_differences = 0; ///< over the largest entry of their kind of block
};

/// Largest error of the stiffness against differences, and of these against those at another step.
Errors errors_of(Bodies& bodies, const StaticState& state) {
    const Eigen::MatrixXd k(*bodies.system.balance(state, true).stiffness);
    const int count = bodies.system.unknowns();
    const Eigen::MatrixXd d = differences(bodies, state, 3e-5), other = differences(bodies, state, 2e-5);
    double largest[2][2] = {};
    const auto kind = [&](int i) { return bodies.system.map().place(i).i < 3 ? 0 : 1; };
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j)
            largest[kind(i)][kind(j)] = std::max(largest[kind(i)][kind(j)], std::abs(k(i, j)));
    Errors errors;
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) {
            const double size = std::max(largest[kind(i)][kind(j)], 1e-300);
            errors.difference = std::max(errors.difference, std::abs(k(i, j) - d(i, j)) / size);
            errors.of_differences = std::max(errors.of_differences, std::abs(other(i, j) - d(i, j)) / size);
            errors.asymmetry = std::max(errors.asymmetry, std::abs(k(i, j) - k(j, i)) / size);
        }
    return errors;
}

void expect_stiffness(SceneSpec scene, const std::string& name, bool conservative, double disturbed = 2e-3) {
    Bodies bodies(std::move(scene));
    std::mt19937 random(1);
    int known = 0; // states in which differences are exact: a spring that has just begun to push has none
    for (int i = 0; i < 40 && known < 20; ++i) {
        const Errors errors = errors_of(bodies, bodies.disturbed(disturbed, random));
        if (errors.of_differences > 5e-9) continue;
        ++known;
        EXPECT_LT(errors.difference, 1e-8) << name;
        if (conservative) {
            EXPECT_LT(errors.asymmetry, 1e-12) << name;
        }
        if (testing::Test::HasFailure()) return;
    }
    EXPECT_GE(known, 10) << name;
}

SceneSpec scene_of(RodSpec rod) {
    SceneSpec scene;
    scene.rods = {std::move(rod)};
    scene.time.duration = 1;
    return scene;
}

TEST(Stiffness, OfEveryLawAndEnd) {
    for (const Law law : test::energy_laws())
        for (const EndKind start : {EndKind::free, EndKind::pinned, EndKind::clamped, EndKind::clamped_frozen})
            for (const EndKind end : {EndKind::free, EndKind::clamped}) {
                RodSpec rod = test::crooked_rod(5);
                rod.material.law = law;
                rod.start = start;
                rod.end = end;
                expect_stiffness(scene_of(rod), test::name_of(law), true);
            }
}

TEST(Stiffness, OfRings) {
    for (const Law law : test::energy_laws()) {
        RodSpec rod = test::simple_rod(8);
        rod.shape.closed = true;
        rod.material.law = law;
        expect_stiffness(scene_of(rod), test::name_of(law), true);
    }
}

TEST(Stiffness, OfThePublishedLaw) {
    RodSpec rod = test::simple_rod(6);
    rod.material.law = Law::elastica;
    rod.start = EndKind::clamped;
    expect_stiffness(scene_of(rod), "elastica", false);
}

TEST(Stiffness, OfHeldAndGuidedPlaces) {
    RodSpec rod = test::crooked_rod(6);
    rod.start = EndKind::clamped;
    rod.start_free = "x";
    rod.hold.nodes = {3};
    rod.hold.directions = "xz";
    expect_stiffness(scene_of(rod), "held", true);
}

TEST(Stiffness, OfElementsHeldAboutLabAxes) {
    for (const char* axes : {"x", "y", "z", "xy", "yz"}) {
        RodSpec rod = test::crooked_rod(6);
        rod.start = EndKind::clamped;
        rod.hold.elements = {2, 4};
        rod.hold.axes = axes;
        expect_stiffness(scene_of(rod), axes, std::string_view(axes).size() == 2);
    }
}

TEST(Stiffness, OfEveryLoad) {
    for (const test::LoadExample& example : test::load_examples()) {
        RodSpec rod = test::crooked_rod(6);
        rod.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 5e3, .direction = {1, 2, 2}};
        rod.material.youngs_modulus = 1e4; // so that loads show
        SceneSpec scene = scene_of(rod);
        scene.loads.push_back({.load = example.load});
        expect_stiffness(scene, example.name(), bool(example.potential));
    }
}

TEST(Stiffness, OfEveryJoint) {
    for (const test::JointExample& example : test::joint_examples())
        expect_stiffness(example.scene, example.name, false, 1e-3);
}

TEST(Stiffness, OfCommonNodes) {
    for (const test::JointExample& example : test::common_node_examples())
        expect_stiffness(example.scene, example.name, true, 1e-3);
}

/// Muscles bend the cell that a common node makes of two ends.
TEST(Stiffness, OfMusclesThroughCommonNodes) {
    for (const test::JointExample& example : test::common_node_examples()) {
        SceneSpec scene = example.scene;
        scene.loads.push_back({.load = test::muscles_by_formula({1, -2, 0.5}, LoadFrame::body)});
        expect_stiffness(scene, example.name, false, 1e-3);
    }
}

} // namespace
} // namespace skein
