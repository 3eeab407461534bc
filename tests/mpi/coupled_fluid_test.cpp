// Rods and bodies with sharp surfaces in a fluid: sums over ranks are those that a step needs.
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "simulation/world.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace skein {
namespace {

/// A rod of four cells across, and a ball, in a fluid at rest.
SceneSpec in_fluid(bool has_rod, bool has_ball) {
    SceneSpec scene;
    scene.fluid = FluidSpec{.cells = {24, 16, 16},
                            .spacing = 0.1,
                            .density = 1,
                            .viscosity = 0.01,
                            .courant = 0.4,
                            .expected_speed = 1,
                            .largest_slip = 0};
    scene.immersion.body_surface = scene.immersion.rod_surface = SurfaceKind::sharp;
    if (has_rod) {
        RodSpec rod = test::simple_rod(6);
        rod.material.density = 2;
        rod.section.radius = 0.2;
        rod.shape.velocity = {0.1, 0, 0};
        rod.placement.origin = {0.6, 0.8, 0.3};
        scene.rods.push_back(rod);
    }
    if (has_ball) {
        RodSpec ball = test::rigid_body(0, 0.25);
        ball.name = "ball";
        ball.shape.velocity = {0.1, 0, 0};
        ball.placement.origin = {1.7, 0.8, 0.8};
        scene.rods.push_back(ball);
    }
    scene.time = {.duration = 0.2, .dt = 1e-4};
    return scene;
}

/// Collective calls of a run in its steps, by step of the fluid; these follow each other without a pause.
double calls_in_a_step(const SceneSpec& scene) {
    const Communicator comm = Communicator::world();
    const Threads threads(1);
    std::vector<RodGroup> groups = make_groups(scene);
    Plan plan = make_plan(scene, groups, {comm.size(), 1, 1, 1, {}, Mapping::automatic});
    const std::int64_t every = plan.events_every;
    World world(comm, threads, std::move(groups), std::move(plan), Protocol::asynchronous, Balance::never);
    world.advance(every);
    const std::int64_t before = Communicator::traffic().calls;
    constexpr int steps = 3;
    for (int s = 1; s <= steps; ++s) world.advance((s + 1) * every);
    EXPECT_TRUE(world.failure().empty()) << world.failure();
    return static_cast<double>(Communicator::traffic().calls - before) / steps;
}

/// The fluid within bodies decides how they move at the begin of a step, and that within rods nothing.
TEST(SharpSurfaces, FluidWithinIsSummedForRigidBodiesAlone) {
    const double rod = calls_in_a_step(in_fluid(true, false)), both = calls_in_a_step(in_fluid(true, true));
    EXPECT_EQ(both - rod, 2) << "a largest term and a sum";
}

} // namespace
} // namespace skein
