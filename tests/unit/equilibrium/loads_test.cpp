// Loads of bodies at rest against those of a run: the velocities that its first step, of rods without any, gives them.
// This is all that the passes of the plan, walls and joints do at zero rates, as the state has not moved before.
#include "equilibrium/static_system.hpp"
#include "kernels/kernels.hpp"
#include "physics/walls/wall_plan.hpp"
#include "support/interaction_examples.hpp"
#include "support/joint_examples.hpp"
#include "support/load_examples.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace skein {
namespace {

/// Largest difference over the largest of both kinds of load.
double difference(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double off = 0, size = 1e-300;
    for (std::size_t s = 0; s < a.size(); ++s) {
        off = std::max(off, norm(a[s] - b[s]));
        size = std::max({size, norm(a[s]), norm(b[s])});
    }
    return off / size;
}

/// Loads of a run on bodies at rest in disturbed places, N and N m.
void expect_loads_of_a_run(SceneSpec scene, const std::string& name) {
    for (RodSpec& rod : scene.rods) rod.shape.velocity = rod.shape.angular_velocity = {0, 0, 0};
    scene.time.duration = 1;
    test::Stage stage(std::move(scene), 1);
    std::vector<Slot<1>> state;
    for (std::size_t i = 0; i < stage.rods->local().size(); ++i) {
        const RodGroup& group = nth(stage.groups, stage.rods->local()[i].group);
        const double size = group.strained() ? 1e-3 : 1e-4;
        std::vector<Slot<1>> own = test::shaken_state(group, size, size, 0);
        if (group.closed()) own.back() = own.front();
        stage.rods->import_rod(i, own);
        stage.rods->export_rod(i, own);
        state.insert(state.end(), own.begin(), own.end());
    }
    const auto* walls = stage.plan.find<WallPlan>();
    const auto at_rest = make_static_rods(stage.plan, stage.groups, stage.rods->local(),
                                          walls ? std::make_shared<Walls>(walls->walls) : nullptr);
    at_rest->set_time(stage.clock.next(1, 1).front().time);
    StaticLoads loads;
    at_rest->evaluate(state, at_rest->strains(state), false, loads);
    stage.advance(1);
    std::vector<Vec3d> force(state.size()), couple(state.size()), mine = loads.force, turning = loads.couple;
    for (std::size_t i = 0; i < stage.rods->local().size(); ++i) {
        const RodGroup& group = nth(stage.groups, stage.rods->local()[i].group);
        const std::size_t first = at_rest->first_slot(i);
        std::vector<Slot<1>> own(to_index(group.slots()));
        stage.rods->export_rod(i, own);
        for (std::size_t k = 0; k < own.size(); ++k) {
            force[first + k] = (group.node_mass[k] / stage.plan.dt) * lane(own[k].velocity, 0);
            if (group.holds_node(static_cast<int>(k))) force[first + k] = mine[first + k];
            if (k >= group.element.size()) continue;
            // Spin of the published law is that of e J.
            const double e = group.law() == Law::elastica ? norm(at_rest->strains(state)[first + k]) : 1;
            couple[first + k] = (1 / (e * stage.plan.dt)) * scale(group.element[k].inertia, lane(own[k].spin, 0));
            if (group.holds_element(static_cast<int>(k))) couple[first + k] = turning[first + k];
        }
    }
    EXPECT_LT(difference(force, mine), 1e-12) << name << ": forces";
    EXPECT_LT(difference(couple, turning), 1e-12) << name << ": couples";
}

SceneSpec scene_of(RodSpec rod) {
    SceneSpec scene;
    scene.rods = {std::move(rod)};
    return scene;
}

TEST(LoadsAtRest, OfLawsAndEnds) {
    for (std::size_t i = 0; i < std::size(law_names); ++i)
        for (const EndKind start : {EndKind::free, EndKind::pinned, EndKind::clamped}) {
            const auto law = static_cast<Law>(i);
            RodSpec rod = law == Law::elastica ? test::simple_rod(8) : test::crooked_rod(8);
            rod.material.law = law;
            rod.start = start;
            expect_loads_of_a_run(scene_of(rod), test::name_of(law));
        }
}

TEST(LoadsAtRest, OfRingsAndEndWeights) {
    RodSpec ring = test::simple_rod(8);
    ring.shape.closed = true;
    expect_loads_of_a_run(scene_of(ring), "ring");
    RodSpec weighted = test::simple_rod(8);
    weighted.start = EndKind::clamped;
    weighted.shape.end_weights = EndWeights::gregory;
    for (const Law law : test::energy_laws()) {
        weighted.material.law = law;
        expect_loads_of_a_run(scene_of(weighted), test::name_of(law) + ", gregory");
    }
}

TEST(LoadsAtRest, OfLoads) {
    for (const test::LoadExample& example : test::load_examples()) {
        if (example.load.kind() == "anisotropic_plane")
            continue; // feels the loads before it: scenes with it are refused
        RodSpec rod = test::crooked_rod(6);
        rod.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 5e3, .direction = {1, 2, 2}};
        rod.material.youngs_modulus = 1e4; // so that loads show
        SceneSpec scene = scene_of(rod);
        scene.loads.push_back({.load = example.load});
        expect_loads_of_a_run(scene, example.name());
    }
}

TEST(LoadsAtRest, OfJoints) {
    for (const test::JointExample& example : test::joint_examples(1e4, 1.0))
        expect_loads_of_a_run(example.scene, example.name);
}

TEST(LoadsAtRest, OfWalls) {
    for (const test::InteractionExample& example : test::interaction_examples()) {
        if (!example.has_walls) continue;
        SceneSpec scene = example.scene({.stiffness = 1e4}, test::Turn{});
        scene.rods[0].placement.origin.z -= 0.05; // so that it touches
        scene.time.dt = 1e-5;
        expect_loads_of_a_run(scene, example.name);
    }
}

} // namespace
} // namespace skein
