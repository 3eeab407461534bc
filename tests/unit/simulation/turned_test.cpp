// A scene that is turned and shifted, with all of its lab vectors, gives the same results: over loads, dampers, laws
// and ends. And what couples do to the momentum and the energy of rods that tumble, and drag to the step.
#include "scene/make_groups.hpp"
#include "support/dampers.hpp"
#include "support/energy.hpp"
#include "support/free_rods.hpp"
#include "support/load_examples.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

using test::Turn;

RodSpec moving_rod(EndKind start, EndKind end) {
    RodSpec rod = test::crooked_rod(7);
    rod.start = start;
    rod.end = end;
    rod.shape.start_curvature = Vec3d{0.8, -0.5, 0.6};
    rod.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 5e3, .direction = {1, 2, 2}};
    if (start == EndKind::free && end == EndKind::free) {
        rod.shape.velocity = {0.1, 0.2, -0.1};
        rod.shape.element_spin = {0.3, -0.2, 2.0};
    }
    return rod;
}

/// Runs a scene as it is and turned: the largest difference of positions, m, directors and velocities, m/s.
double difference(const SceneSpec& scene, const SceneSpec& turned_scene, const Turn& turn) {
    test::Stage here(scene, 1), there(turned_scene, 1);
    here.advance(200);
    there.advance(200);
    const auto expected = turn.state(here.state(0)), found = there.state(0);
    double most = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        most = std::max(most, norm(lane(expected[i].position, 0) - lane(found[i].position, 0)));
        most = std::max(most, norm(lane(expected[i].velocity, 0) - lane(found[i].velocity, 0)));
        if (i + 1 < expected.size())
            most = std::max(most, 1 - std::abs(dot(lane(expected[i].director, 0), lane(found[i].director, 0))));
    }
    return std::isfinite(most) ? most : 1e300;
}

SceneSpec scene_of(const RodSpec& rod) {
    SceneSpec scene;
    scene.rods = {rod};
    scene.time = {.duration = 1, .dt = 1e-4};
    return scene;
}

Turn some_turn() { return {rotation(Vec3d{0.7, -1.3, 2.1}), {0.3, -0.8, 1.1}}; }

TEST(TurnedScenes, AreTheSameUnderEveryLoad) {
    const Turn turn = some_turn();
    const RodSpec rod = moving_rod(EndKind::free, EndKind::free);
    for (const test::LoadExample& e : test::load_examples()) {
        SceneSpec scene = scene_of(rod), turned = scene_of(turn.rod(rod));
        scene.loads = {{.load = e.load}};
        turned.loads = scene.loads;
        e.turn(turned.loads[0].load, turn);
        EXPECT_LT(difference(scene, turned, turn), 1e-10) << e.name();
    }
}

TEST(TurnedScenes, AreTheSameUnderEveryDamperLawAndEnd) {
    const Turn turn = some_turn();
    for (const Law law : {Law::incompressible, Law::linear, Law::elastica})
        for (std::size_t start = 0; start < std::size(end_names); ++start)
            for (std::size_t end = 0; end < std::size(end_names); ++end) {
                RodSpec rod = moving_rod(static_cast<EndKind>(start), static_cast<EndKind>(end));
                rod.material.law = law;
                if (law == Law::elastica) rod.shape.rest_strain = {0, 0, 0};
                SceneSpec scene = scene_of(rod), turned = scene_of(turn.rod(rod));
                const DampingKind damper = test::all_dampers()[(start + end) % std::size(damping_names)];
                scene.damping = turned.damping = {{.damping = test::damper(damper)}};
                EXPECT_LT(difference(scene, turned, turn), 1e-10)
                    << end_names[start] << ", " << end_names[end] << ", " << test::name_of(damper) << ", law "
                    << static_cast<int>(law);
            }
}

// Internal actuation carries no momentum, however the rod tumbles.
TEST(TumblingRods, KeepTheirMomentaUnderMuscles) {
    for (const test::LoadExample& e : test::load_examples()) {
        if (!e.internal) continue;
        for (const bool elliptic : {false, true}) {
            SceneSpec scene = test::flying_rod(elliptic, 1);
            scene.rods[0].shape.start_curvature = Vec3d{0.5, 0.5, 1.0};
            scene.loads = {{.load = e.load}};
            test::Stage stage(scene, 1);
            const test::Momenta before = test::momenta(stage.groups[0], stage.state(0));
            double most = 0; // of what the elements carry, whose sum the momentum is
            for (int part = 1; part <= 10; ++part) {
                stage.advance(part * 100);
                const auto state = stage.state(0);
                double carried = 0;
                for (std::size_t i = 0; i < state.size(); ++i)
                    carried += stage.groups[0].node_mass[i] * norm(lane(state[i].velocity, 0));
                most = std::max(most, carried);
                const test::Momenta now = test::momenta(stage.groups[0], state);
                EXPECT_LT(norm(now.linear - before.linear), 1e-12 * most) << e.name();
                EXPECT_LT(norm(now.angular - before.angular), 1e-12 * most) << e.name();
            }
        }
    }
}

// Lab couples add their impulse to the angular momentum: C t, to round-off at any step.
TEST(TumblingRods, GainTheImpulseOfEndCouples) {
    SceneSpec scene = test::flying_rod(true, 1);
    const EndCouple load{.start = {0.01, 0.02, -0.01}, .end = {-0.02, 0.01, 0.03}};
    scene.loads = {{.load = load}};
    test::Stage stage(scene, 1);
    const test::Momenta before = test::momenta(stage.groups[0], stage.state(0));
    stage.advance(500);
    const test::Momenta now = test::momenta(stage.groups[0], stage.state(0));
    const Vec3d impulse = (500 * stage.plan.dt) * (load.start + load.end);
    EXPECT_LT(norm(now.angular - before.angular - impulse), 1e-11 * norm(before.angular));
    EXPECT_GT(norm(impulse), 1e-4 * norm(before.angular));
    EXPECT_LT(norm(now.linear - before.linear), 1e-12 * norm(before.linear));
}

// The audit's work of the couples is what the energy gains, but for the energy error of the step, of second order.
TEST(TumblingRods, GainTheWorkOfEndCouples) {
    for (const LoadFrame frame : {LoadFrame::lab, LoadFrame::body}) {
        const auto miss = [&](int steps) {
            SceneSpec scene = test::flying_rod(false, 1);
            scene.rods[0].shape.start_curvature = Vec3d{0.2, 0.1, 0.1};
            scene.loads = {
                {.load = EndCouple{
                     .start = {0.01, 0.02, -0.01}, .end = {-0.02, 0.01, 0.03}, .frame = frame, .ramp = {0.02}}}};
            scene.output.audit = true;
            scene.time.dt = 0.04 / steps;
            test::Stage stage(scene, 1);
            const double before = test::energy(stage.groups[0], stage.state(0));
            stage.advance(steps);
            const double gained = test::energy(stage.groups[0], stage.state(0)) - before,
                         work = stage.rods->budget(0).loads;
            EXPECT_NE(work, 0);
            return std::abs(gained - work) / std::abs(work);
        };
        const double coarse = miss(1000), fine = miss(2000);
        EXPECT_LT(fine, 1e-2);
        EXPECT_NEAR(std::log2(coarse / fine), 2, 0.3) << coarse << " " << fine;
    }
}

// A light rod, whose drag is stiff: every load that says a rate is the first of the limits, and a rod shaken at the
// automatic step loses energy. A plane has its spring taken off, whose energy is none of the rod's.
TEST(LimitOfTheStep, FallsUnderEveryLoadThatSaysARate) {
    SceneSpec scene;
    scene.rods = {test::simple_rod(7)};
    scene.rods[0].material.density = 0.01;
    scene.time = {.duration = 1};
    const double before = test::Stage(scene, 1).plan.groups[0].limits.front().dt;
    int loads = 0;
    for (const test::LoadExample& e : test::load_examples()) {
        const auto groups = make_groups(scene);
        if (e.load.largest_rate(groups[0]).value == 0) continue;
        ++loads;
        SceneSpec dragged = scene;
        dragged.loads = {{.load = e.load}};
        if (auto* plane = dragged.loads[0].load.get_if<PlaneFriction>()) plane->stiffness = 0;
        test::Stage stage(dragged, 1);
        EXPECT_LT(stage.plan.groups[0].limits.front().dt, 0.97 * before) << e.name();
        stage.rods->import_rod(0, test::shaken_state(stage.groups[0], 0, 0, 1));
        const double start = test::energy(stage.groups[0], stage.state(0));
        stage.advance(1000);
        EXPECT_LT(test::energy(stage.groups[0], stage.state(0)), start) << e.name();
    }
    EXPECT_GE(loads, 2);
}

} // namespace
} // namespace skein
