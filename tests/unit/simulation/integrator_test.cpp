// Order of the integrators, rings that keep their momenta, ends that move.
#include "core/rotation.hpp"
#include "mechanics/rod_copies.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace skein {
namespace {

SceneSpec bent_rod(Integrator integrator, double dt, Law law = Law::incompressible) {
    SceneSpec scene;
    RodSpec rod = test::simple_rod(12);
    rod.material.law = law;
    rod.section = {.radius = 0.03};
    rod.shape.start_curvature = Vec3d{1.5, 0.5, 1.0};
    rod.shape.element_spin = {0.3, -0.2, 2.0};
    scene.rods = {rod};
    scene.time = {.duration = 1, .dt = dt, .integrator = integrator};
    return scene;
}

/// State after time T in so many steps.
std::vector<Slot<1>> after(SceneSpec scene, double time, std::int64_t steps) {
    scene.time.dt = time / static_cast<double>(steps);
    test::Stage stage(std::move(scene));
    stage.advance(steps);
    return stage.state(0);
}

/// Error ratio on halving the step, against a much finer run.
double ratio(const SceneSpec& scene, double time, std::int64_t steps, std::int64_t finest) {
    const auto exact = after(scene, time, finest);
    return test::distance(after(scene, time, steps), exact) / test::distance(after(scene, time, 2 * steps), exact);
}

TEST(Integrators, HaveTheirOrder) {
    for (const Law law : test::energy_laws()) {
        EXPECT_NEAR(ratio(bent_rod(Integrator::verlet, 1, law), 0.2, 1500, 48000), 4, 0.2);
        EXPECT_NEAR(ratio(bent_rod(Integrator::pefrl, 1, law), 0.2, 400, 4000), 16, 1.5);
    }
}

TEST(Integrators, KeepTheirOrderUnderDamping) {
    for (const DampingKind kind : {DampingKind::uniform, DampingKind::legacy}) {
        SceneSpec scene = bent_rod(Integrator::pefrl, 1);
        scene.damping.push_back(
            {.damping = {.kind = kind, .rate = kind == DampingKind::legacy ? 0.02 : 2}}); // 36 1/s about d1
        EXPECT_NEAR(ratio(scene, 0.2, 400, 4000), 16, 1.5);
        scene.time.integrator = Integrator::verlet;
        EXPECT_NEAR(ratio(scene, 0.2, 1500, 48000), 4, 0.2);
        scene.time.damping = DampingScheme::after;
        EXPECT_NEAR(ratio(scene, 0.2, 3000, 96000), 2, 0.2);
    }
}

TEST(Ring, SpinsWithoutLosingMomentum) {
    SceneSpec scene = bent_rod(Integrator::verlet, 0);
    RodSpec& ring = scene.rods[0];
    ring.shape = {
        .length = 1, .elements = 24, .closed = true, .velocity = {0.1, -0.2, 0.3}, .element_spin = {0.5, 1, 3}};
    test::Stage stage(scene);
    const auto [p0, l0] = test::momenta(stage.groups[0], stage.state(0));
    stage.advance(20000);
    const auto [p1, l1] = test::momenta(stage.groups[0], stage.state(0));
    EXPECT_LT(norm(p1 - p0), 1e-12 * norm(p0));
    EXPECT_LT(norm(l1 - l0), 1e-11 * norm(l0));
    const auto state = stage.state(0);
    EXPECT_EQ(norm(lane(state.front().position, 0) - lane(state.back().position, 0)), 0.0);

    auto positions_alone = state;
    stage.rods->export_rod(0, positions_alone);
    synchronise_positions(stage.groups[0], positions_alone, stage.clock.lag());
    for (std::size_t i = 0; i < state.size(); ++i)
        EXPECT_EQ(norm(lane(state[i].position, 0) - lane(positions_alone[i].position, 0)), 0.0) << "node " << i;
}

TEST(Ring, TurnOfMoreThanThreeRadiansWhereItClosesIsFound) {
    for (const double turn : {2.9, 3.05}) {
        SceneSpec scene = bent_rod(Integrator::verlet, 0);
        scene.rods[0].shape = {.length = 1, .elements = 24, .closed = true};
        test::Stage stage(scene);
        auto state = stage.state(0);
        for (std::size_t k = 0; k < 24; ++k) // evenly twisted, all of it taken back in the last cell
            set_lane(state[k].director, 0,
                     rotation({0, 0, turn / 23 * static_cast<double>(k)}) * lane(state[k].director, 0));
        stage.rods->import_rod(0, state);
        EXPECT_EQ(stage.rods->advance({}, true), turn < 3);
        if (turn > 3) {
            EXPECT_THROW(stage.rods->inspect(0, 1e-3), NumericalError);
        }
    }
}

TEST(Ring, CircleAtRestStays) {
    SceneSpec scene = bent_rod(Integrator::verlet, 0);
    scene.rods[0].shape = {.length = 1, .elements = 24, .closed = true};
    test::Stage stage(scene);
    const auto before = stage.state(0);
    stage.advance(2000);
    EXPECT_LT(test::distance(before, stage.state(0)), 1e-13);
}

/// Both ends moved and turned smoothly: energy less the walls' work is conserved to second order, here seen in the end
/// state.
TEST(MovingEnds, AreSecondOrder) {
    SceneSpec scene = bent_rod(Integrator::verlet, 1);
    RodSpec& rod = scene.rods[0];
    rod.shape = {.length = 1, .elements = 12};
    rod.start = rod.end = EndKind::clamped;
    rod.start_motion = {.times = {0, 0.2},
                        .translation = {{0, 0, 0}, {0.05, 0.02, 0.1}},
                        .rotation = {{0, 0, 0}, {0.5, 0.3, -0.8}},
                        .smooth = true};
    rod.end_motion = {.times = {0, 0.2},
                      .translation = {{0, 0, 0}, {-0.1, 0, -0.05}},
                      .rotation = {{0, 0, 0}, {-0.4, 0.9, 0.6}},
                      .smooth = true};
    EXPECT_NEAR(ratio(scene, 0.2, 1500, 48000), 4, 0.2);
    const auto state = after(scene, 0.2, 3000);
    EXPECT_LT(norm(lane(state[0].position, 0) - Vec3d{0.05, 0.02, 0.1}), 1e-6);
    EXPECT_LT(norm(lane(state[12].position, 0) - Vec3d{-0.1, 0, 0.95}), 1e-6);
}

/// A motion, named and as formulas.
struct WrittenMotion {
    EndMotion named, written;
};
std::vector<WrittenMotion> written_motions() {
    const double pi = 3.14159265358979323846;
    const std::string smooth = "ramp(t, b)^2*(3 - 2*ramp(t, b))";
    return {{{.amplitude = {0.02, 0, -0.03}, .rotation_amplitude = {0, 0.4, 0.2}, .period = 0.3, .phase = pi / 3},
             {.translation_formula = {"2*d*sin(2*pi*t/T + pi/3)", "0", "-3*d*sin(2*pi*t/T + pi/3)"},
              .rotation_formula = {"0", "0.4*sin(2*pi*t/T + pi/3)", "0.2*sin(2*pi*t/T + pi/3)"}}},
            {{.times = {0, 0.1},
              .translation = {{0, 0, 0}, {0.01, 0.02, 0}},
              .rotation = {{0, 0, 0}, {0.5, 0, -0.3}},
              .smooth = true},
             {.translation_formula = {"d*" + smooth, "2*d*" + smooth, "0"},
              .rotation_formula = {"0.5*" + smooth, "0", "-0.3*" + smooth}}},
            {{.times = {0, 0.1, 0.2}, .translation = {{0, 0, 0}, {0, 0.01, 0}, {0, 0.03, 0}}},
             {.translation_formula = {"0", "lift(t)", "0"}}}};
}

TEST(MovingEnds, AreTheSameAsFormulas) {
    for (const WrittenMotion& motion : written_motions()) {
        SceneSpec scene = bent_rod(Integrator::verlet, 1);
        RodSpec& rod = scene.rods[0];
        rod.shape = {.length = 1, .elements = 12};
        rod.start = EndKind::clamped;
        scene.constants = {{"d", 0.01, "m"}, {"T", 0.3, "s"}, {"b", 0.1, "s"}};
        scene.tables = {{.name = "lift", .at = {0, 0.1, 0.2}, .value = {0, 0.01, 0.03}, .at_unit = "s", .unit = "m"}};
        rod.start_motion = motion.named;
        const auto named = after(scene, 0.15, 3000);
        rod.start_motion = motion.written;
        const auto written = after(scene, 0.15, 3000);
        EXPECT_LT(test::distance(named, written), 1e-13);
        rod.start_motion = {};
        EXPECT_GT(test::distance(named, after(scene, 0.15, 3000)), 1e-3);
    }
}

/// An end drawn away along the rod: until the wave meets the other end, u(s, t) = f(t - s/c) with c^2 = E/rho, of small
/// strain.
TEST(MovingEnds, SendAWaveAlongTheRod) {
    SceneSpec scene;
    RodSpec rod = test::simple_rod(40);
    const double length = rod.shape.length, c = std::sqrt(rod.material.youngs_modulus / rod.material.density);
    rod.start = EndKind::pinned;
    scene.constants = {{"d", 1e-6 * length, "m"}, {"T", length / c, "s"}};
    rod.start_motion.translation_formula = {"0", "0", "-d*(t/T)^4"};
    const auto error = [&](int elements) {
        rod.shape.elements = elements;
        scene.rods = {rod};
        const double time = 0.9 * length / c;
        const auto state = after(scene, time, 40 * elements);
        double most = 0;
        for (int i = 0; i <= elements; ++i) {
            const double s = length * i / elements, phase = std::max(0.0, 0.9 - s / length);
            const double moved = lane(nth(state, i).position, 0).z - s;
            most = std::max(most, std::abs(moved + 1e-6 * length * std::pow(phase, 4)));
        }
        return most / (1e-6 * length);
    };
    const double coarse = error(20), fine = error(40);
    EXPECT_NEAR(coarse / fine, 4, 0.4);
    EXPECT_LT(fine, 2e-3);
}

TEST(Hold, KeepsItsNodesAndElements) {
    SceneSpec scene = bent_rod(Integrator::verlet, 0);
    scene.rods[0].hold = {.nodes = {3, -1}, .elements = {5}, .directions = "xz", .axes = "xyz"};
    test::Stage stage(scene);
    const auto before = stage.state(0);
    stage.advance(2000);
    const auto now = stage.state(0);
    for (const std::size_t i : {std::size_t{3}, std::size_t{12}}) {
        const Vec3d moved = lane(now[i].position, 0) - lane(before[i].position, 0);
        EXPECT_EQ(moved.x, 0);
        EXPECT_EQ(moved.z, 0);
        EXPECT_GT(std::abs(moved.y), 1e-6);
    }
    EXPECT_LT(norm(frame(now[5]).d1 - frame(before[5]).d1), 1e-15);
}

} // namespace
} // namespace skein
