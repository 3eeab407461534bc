// Bodies in a fluid: the same bits on any ranks, what they give the fluid, and the drag of a sphere.
#include "fluid/make_flow.hpp"
#include "immersion/immersion.hpp"
#include "skein/core/index.hpp"
#include "support/whole_state.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skein {
namespace {

FlowConstants still_box(std::array<int, 3> cells) {
    FlowConstants c{
        .grid = {.cells = cells, .h = 0.1, .lower = {-0.3, 0.2, 0.05}}, .density = 2, .kinematic_viscosity = 5e-3};
    return c;
}

/// One that swings across the planes that ranks share, one that moves through the sides of the box.
std::vector<Obstacle> moving_bodies() {
    Obstacle ball;
    ball.name = "ball";
    ball.centre = {0.43, 1.12, 0.81};
    ball.radius = 0.31;
    ball.amplitude = {0.05, 0.02, 0.3};
    ball.frequency = 0.7;
    Obstacle tube;
    tube.name = "tube";
    tube.kind = ObstacleKind::cylinder;
    tube.centre = {1.5, 0.25, 0};
    tube.radius = 0.3;
    tube.second_radius = 0.2;
    tube.velocity = {0.4, -0.5, 0.1};
    return {ball, tube};
}

struct Swum {
    std::vector<double> state;
    Vec3d given{0, 0, 0}, gained{0, 0, 0}, couple{0, 0, 0};
    double slip = 0, speed = 0;
};

Swum swum(const Communicator& comm, const Threads& threads, FlowScheme scheme, DeltaKind delta, int across = 1) {
    FlowConstants constants = still_box({24, 20, 16});
    constants.scheme = scheme;
    constants.ranks_across = across;
    auto flow = make_flow(comm, threads, constants);
    flow->set_velocity([](const Vec3d&) { return Vec3d{0, 0, 0}; });
    Immersion bodies(comm, threads, constants.grid, {.delta = delta, .sweeps = 3}, moving_bodies(), nullptr, across);
    flow->set_forcing(&bodies.forcing());
    bodies.begin_interval(0);
    for (int s = 0; s < 6; ++s) flow->step(0.03 * s, 0.03);
    bodies.sum_loads();
    Swum all;
    for (const Vec3d& given : bodies.forcing().given().of_body()) all.given += constants.density * given;
    const FlowFigures figures = figures_of(comm, *flow);
    all.gained = figures.momentum;
    all.speed = figures.speed;
    all.slip = bodies.forcing().slip();
    all.couple = bodies.couple_on_obstacle(1, constants.density, 0.18);
    all.state = test::state_on_all_ranks(comm, *flow);
    return all;
}

TEST(Obstacles, HaveTheSameBitsOnAnyRanksAndGiveWhatTheFluidGains) {
    const Threads threads(1), team(2);
    for (const FlowScheme scheme :
         {FlowScheme::rk3, FlowScheme::rk3_projected, FlowScheme::adams_bashforth, FlowScheme::crank_nicolson})
        for (const DeltaKind delta : {DeltaKind::three_point, DeltaKind::four_point}) {
            const Swum here = swum(Communicator::world(), threads, scheme, delta);
            EXPECT_EQ(here.state, swum(Communicator::alone(), threads, scheme, delta).state);
            const Swum by_team = swum(Communicator::world(), team, scheme, delta);
            EXPECT_EQ(here.state, by_team.state);
            EXPECT_EQ(here.couple.z, by_team.couple.z);
            EXPECT_GT(std::abs(here.couple.z), 1e-6);
            for (const int across : {2, Communicator::world().size()}) {
                if (across == 1 || Communicator::world().size() % across != 0) continue;
                const Swum pencils = swum(Communicator::world(), team, scheme, delta, across);
                EXPECT_EQ(here.state, pencils.state) << across << " ranks across";
                EXPECT_EQ(here.slip, pencils.slip);
                EXPECT_EQ(here.given.x, pencils.given.x);
                EXPECT_EQ(here.couple.z, pencils.couple.z);
            }
            EXPECT_GT(norm(here.gained), 1e-3);
            EXPECT_LT(norm(here.given - here.gained), 1e-13);
            EXPECT_LT(here.slip, 0.1 * here.speed);
        }
}

/// Collective calls in three steps of a fluid from its second step on, where bodies with markers rest in it or none
/// are, and the loads at the end.
struct Calls {
    std::int64_t in_steps, in_sums;
    std::vector<Vec3d> loads;

    Calls(bool has_bodies, bool sums_each_step) {
        const Communicator comm = Communicator::world();
        const Threads threads(1);
        const FlowConstants constants = still_box({24, 20, 16});
        auto flow = make_flow(comm, threads, constants);
        flow->set_velocity([](const Vec3d& at) { return Vec3d{1 + at.y, 0.3 * at.z, 0}; });
        std::vector<Obstacle> at_rest = moving_bodies();
        for (Obstacle& o : at_rest) o.velocity = o.amplitude = {0, 0, 0};
        Immersion bodies(comm, threads, constants.grid, {}, at_rest);
        if (has_bodies) flow->set_forcing(&bodies.forcing());
        flow->step(0, 0.02);
        bodies.begin_interval(0.02);
        const auto calls = [] { return Communicator::traffic().calls; };
        const std::int64_t before = calls();
        for (int s = 1; s < 4; ++s) {
            flow->step(0.02 * s, 0.02);
            if (sums_each_step) bodies.sum_loads();
        }
        in_steps = calls() - before;
        bodies.sum_loads();
        in_sums = calls() - before - in_steps;
        for (std::size_t o = 0; o < at_rest.size(); ++o) {
            loads.push_back(bodies.force_on_obstacle(o, constants.density, 0.08));
            loads.push_back(bodies.couple_on_obstacle(o, constants.density, 0.08));
        }
    }
};

/// Steps of a body at rest need the largest slip of all ranks, and nothing else.
TEST(Obstacles, LoadsAreSummedOverRanksWhereTheyAreAskedFor) {
    const Calls without(false, false), late(true, false), often(true, true);
    EXPECT_EQ(late.in_steps - without.in_steps, 3);
    EXPECT_EQ(late.in_sums, 4)
        << "a largest term and a sum, of forces and of loads with couples, of all stages at once";
    EXPECT_EQ(often.in_steps - late.in_steps, 3 * late.in_sums);
    for (std::size_t i = 0; i < late.loads.size(); ++i) {
        EXPECT_GT(norm(late.loads[i]), 1e-6);
        EXPECT_EQ(norm(late.loads[i] - often.loads[i]), 0) << i;
    }
}

/// Forces that stay at markers go with these from rank to rank, and to a run that goes on.
TEST(Obstacles, GoOnFromForcesAtMarkers) {
    const Communicator comm = Communicator::world();
    const Threads threads(1);
    FlowConstants constants = still_box({24, 20, 16});
    constants.scheme = FlowScheme::crank_nicolson;
    const auto state_of = [](FlowSolver& flow) {
        std::vector<double> all;
        const FieldLayout layout = flow.layout();
        for (const auto field : flow.state())
            for (int k = 0; k < layout.nz; ++k)
                for (int j = 0; j < layout.ny; ++j)
                    for (int i = 0; i < layout.nx; ++i) all.push_back(nth(field, layout.at(i, j, k)));
        return all;
    };
    auto first = make_flow(comm, threads, constants), second = make_flow(comm, threads, constants);
    Immersion bodies(comm, threads, constants.grid, {}, moving_bodies()),
        others(comm, threads, constants.grid, {}, moving_bodies());
    first->set_velocity([](const Vec3d&) { return Vec3d{0, 0, 0}; });
    first->set_forcing(&bodies.forcing());
    second->set_forcing(&others.forcing());
    for (int s = 0; s < 4; ++s) first->step(0.05 * s, 0.05);
    const std::vector<double> held = bodies.forcing().held().saved(comm);
    std::size_t markers = 0;
    for (const Obstacle& body : moving_bodies()) markers += body.markers(constants.grid).size();
    EXPECT_EQ(held.size(), HeldVectors::record * markers);
    const auto from = first->state(), to = second->state();
    for (std::size_t f = 0; f < from.size(); ++f) std::copy(from[f].begin(), from[f].end(), to[f].begin());
    second->refresh(first->time());
    others.forcing().restore_held(held);
    EXPECT_EQ(others.forcing().held().saved(comm), held);
    for (int s = 4; s < 7; ++s) {
        first->step(0.05 * s, 0.05);
        second->step(0.05 * s, 0.05);
    }
    EXPECT_EQ(state_of(*first), state_of(*second));
    EXPECT_EQ(bodies.forcing().held().saved(comm), others.forcing().held().saved(comm));
    EXPECT_EQ(bodies.forcing().slip(), others.forcing().slip());
}

/// One sphere in a cube of 1 m with periods, driven by an acceleration.
struct SphereArray {
    double drag_factor, force, slip; ///< the last two over what drives it, and over the mean velocity

    SphereArray(int n, double share, double step, int steps) {
        const Communicator comm = Communicator::alone();
        const Threads threads(1);
        const double radius = std::cbrt(3 * share / (4 * std::numbers::pi)), acceleration = 0.5;
        FlowConstants constants{.grid = {.cells = {n, n, n}, .h = 1.0 / n},
                                .kinematic_viscosity = 1,
                                .acceleration = {acceleration, 0, 0},
                                .scheme = FlowScheme::crank_nicolson};
        auto flow = make_flow(comm, threads, constants);
        flow->set_velocity([](const Vec3d&) { return Vec3d{0, 0, 0}; });
        Obstacle sphere;
        sphere.centre = {0.51, 0.5, 0.497};
        sphere.radius = radius;
        sphere.retraction = 0.3;
        Immersion bodies(comm, threads, constants.grid, {}, {sphere});
        flow->set_forcing(&bodies.forcing());
        for (int s = 0; s < steps; ++s) {
            bodies.begin_interval(step * s);
            flow->step(step * s, step);
        }
        const double speed = figures_of(comm, *flow).momentum.x;
        drag_factor = acceleration / (6 * std::numbers::pi * radius * speed);
        bodies.sum_loads();
        force = bodies.force_on_obstacle(0, 1, step * steps).x / acceleration;
        slip = bodies.forcing().slip() / speed;
    }
};

/// Of Zick and Homsy, of second order in the spacing; all that drives the fluid is a force on the sphere.
TEST(Obstacles, SpheresInACubicArrayHaveTheirDrag) {
    if (Communicator::world().size() > 1) GTEST_SKIP() << "the bits are those of one rank";
    for (const auto& [share, published] : {std::pair{0.125, 4.292}, std::pair{0.216, 7.442}}) {
        const SphereArray coarse(24, share, 0.04, 60), fine(36, share, 0.03, 60);
        EXPECT_NEAR(fine.drag_factor, published, 0.02 * published);
        EXPECT_LT(std::abs(fine.drag_factor - published), std::abs(coarse.drag_factor - published) / 2);
        EXPECT_NEAR(fine.force, 1, 1e-3);
        EXPECT_LT(fine.slip, 0.01);
    }
}

/// Steps of 10^4 h^2 / nu, in which a body would stop the fluid many times.
TEST(Obstacles, AnyImplicitStepIsStable) {
    if (Communicator::world().size() > 1) GTEST_SKIP() << "the bits are those of one rank";
    const SphereArray array(16, 0.125, 1e4 / 256, 60);
    EXPECT_NEAR(array.drag_factor, 4.292, 0.1 * 4.292);
    EXPECT_NEAR(array.force, 1, 1e-3);
}

/// In a box of 10 x 6 x 6 diameters, where it is 1.9 % larger than in 14 x 10 x 10, and there 1.087 (kim2001).
TEST(Obstacles, SphereHasItsDrag) {
    const Communicator comm = Communicator::world();
    if (comm.size() > 1) GTEST_SKIP() << "the bits are those of one rank";
    const Threads threads(1);
    FlowConstants constants{
        .grid = {.cells = {80, 48, 48}, .h = 0.125}, .kinematic_viscosity = 0.01, .inflow = {1, 0, 0}};
    constants.grid.boundary = {FluidBoundary::through, FluidBoundary::free_slip, FluidBoundary::free_slip};
    auto flow = make_flow(comm, threads, constants);
    flow->set_velocity([](const Vec3d&) { return Vec3d{1, 0, 0}; });
    Obstacle sphere;
    sphere.centre = {3.5, 3, 3};
    sphere.radius = 0.5;
    Immersion bodies(comm, threads, constants.grid, {}, {sphere});
    flow->set_forcing(&bodies.forcing());
    for (int t = 0; t < 16; ++t) {
        bodies.begin_interval(0.5 * t);
        flow->step_within(0.5 * t, 0.5, 0.8);
    }
    bodies.sum_loads();
    EXPECT_NEAR(bodies.force_on_obstacle(0, 1, 8).x / (0.5 * std::numbers::pi / 4), 1.019 * 1.087, 0.015 * 1.087);
    EXPECT_LT(bodies.forcing().slip(), 0.02);
}

} // namespace
} // namespace skein
