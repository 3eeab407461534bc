// Damping at rest of every load and joint: against differences of the loads by rates, and as dashpots that take power.
#include "equilibrium/static_system.hpp"
#include "kernels/kernels.hpp"
#include "support/joint_examples.hpp"
#include "support/load_examples.hpp"
#include "support/scenes_for_tests.hpp"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace skein {
namespace {

/// Bodies of a scene at their start.
struct Bodies {
    SceneSpec scene;
    std::vector<RodGroup> groups;
    Plan plan;
    std::vector<LocalRod> rods;
    StaticSystem system;

    explicit Bodies(SceneSpec s)
        : scene(std::move(s)), groups(make_groups(scene)), plan(make_plan(scene, groups, {})),
          rods(test::all_rods(groups)), system(groups, rods, make_static_rods(plan, groups, rods, nullptr)) {}
    StaticState start() const { return start_of(system, groups, rods); }
};

/// Loads of a rod whose unknown u has the rate `rate`, by unknown.
Unknown loads_at_rate(const Bodies& bodies, const Load& load, int u, double rate) {
    std::vector<Slot<1>> state = bodies.start().slot;
    const auto put = [](Vec3<Pack<1>>& v, int i, double to) { (i == 0 ? v.x : i == 1 ? v.y : v.z) = to; };
    const Unknowns::Place place = bodies.system.map().place(u);
    Slot<1>& slot = state[to_index(place.slot)];
    put(place.i < 3 ? slot.velocity : slot.spin, place.i % 3, rate);
    const RodTile<1> tile = test::tile_of(bodies.groups[0], state);
    const auto pass = make_pass<1>(load, bodies.groups[0]);
    const Step step{.index = 1, .dt = 1, .drift = 1, .time = 0, .slot = 0};
    std::vector<SlotLoad<1>> sum(state.size(), SlotLoad<1>{});
    pass->bind(tile);
    pass->prepare(std::span(&step, 1));
    pass->run(tile, sum.data(), step);
    Unknown loads(bodies.system.unknowns());
    for (int row = 0; row < loads.size(); ++row) {
        const Unknowns::Place at = bodies.system.map().place(row);
        const Vec3d v = lane(at.i < 3 ? sum[to_index(at.slot)].force : sum[to_index(at.slot)].couple, 0);
        loads[row] = at.i % 3 == 0 ? v.x : at.i % 3 == 1 ? v.y : v.z;
    }
    return loads;
}

TEST(Damping, OfEveryLoad) {
    int damped = 0;
    for (const test::LoadExample& example : test::load_examples()) {
        SceneSpec scene;
        scene.rods = {test::crooked_rod(6)};
        scene.rods[0].magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 5e3};
        scene.time.duration = 1;
        scene.loads.push_back({.load = example.load});
        Bodies bodies(scene);
        const Eigen::MatrixXd found(bodies.system.damping(bodies.start()));
        Eigen::MatrixXd differences(found.rows(), found.cols());
        constexpr double rate = 1e-6;
        for (int u = 0; u < found.cols(); ++u)
            differences.col(u) =
                (loads_at_rate(bodies, example.load, u, -rate) - loads_at_rate(bodies, example.load, u, rate)) /
                (2 * rate);
        // Friction with a corner at rest has no slope there.
        if (example.load.kind() == "anisotropic_plane") continue;
        const double size = std::max(found.cwiseAbs().maxCoeff(), differences.cwiseAbs().maxCoeff());
        damped += size > 1e-6;
        EXPECT_LT((found - differences).cwiseAbs().maxCoeff(), 1e-7 * std::max(size, 1e-2)) << example.name();
    }
    EXPECT_GE(damped, 1) << "drag";
}

TEST(Damping, OfEveryJointTakesPower) {
    int damped = 0;
    for (const test::JointExample& example : test::joint_examples(1e4, 10)) {
        Bodies bodies(example.scene);
        const Eigen::MatrixXd found(bodies.system.damping(bodies.start()));
        const double size = found.cwiseAbs().maxCoeff();
        if (size == 0) continue;
        ++damped;
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (found + found.transpose()));
        EXPECT_GT(solver.eigenvalues().minCoeff(), -1e-10 * size) << example.name;
        EXPECT_LT((found - found.transpose()).cwiseAbs().maxCoeff(), 1e-10 * size) << example.name;
    }
    EXPECT_GE(damped, 3);
}

} // namespace
} // namespace skein
