// The state has the same bits for every SIMD width, thread count and batch length.
#include "loads/end_couple.hpp"
#include "loads/end_force.hpp"
#include "loads/gravity.hpp"
#include "loads/muscle_formula.hpp"
#include "loads/muscle_torques.hpp"
#include "loads/muscle_wave.hpp"
#include "loads/sinusoidal_end_force.hpp"
#include "loads/slender_body_drag.hpp"
#include "loads/uniform_couple.hpp"
#include "loads/uniform_force.hpp"
#include "mechanics/present_eigenvalues.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

namespace skein {
namespace {

/// Every load, damping law, section and kind of end in one scene; groups that do not fill their tiles.
SceneSpec everything() {
    SceneSpec scene = test::cilia_scene(11, 12);
    scene.time = {.duration = 1, .safety = 0.5};
    RodSpec crooked = test::crooked_rod(9);
    crooked.name = "crooked";
    crooked.start = EndKind::pinned;
    crooked.end = EndKind::clamped;
    crooked.placement = {.kind = PlacementKind::lattice, .counts = {3, 2}, .spacing = {0.3, 0.3}};
    RodSpec flat = test::simple_rod(5);
    flat.name = "flat";
    flat.start = EndKind::clamped_frozen;
    flat.section = {.kind = SectionKind::elliptic, .radius = 0.02, .radius_2 = 0.04};
    flat.shape.start_curvature = Vec3d{2.5, 0, 1}; // half a radian per cell: both sides of the polynomials' range
    scene.rods.push_back(crooked);
    scene.rods.push_back(flat);
    scene.loads.push_back({.load = Gravity{}});
    scene.loads.push_back({.load = UniformForce{.force = {0.01, 0, 0}}});
    scene.loads.push_back({.load = UniformCouple{.couple = {0, 1e-4, 0}}, .rods = {"crooked"}});
    scene.loads.push_back({.load = EndForce{.end = {0, 0.02, 0}, .ramp = {0.1}}, .rods = {"flat"}});
    for (const LoadFrame frame : {LoadFrame::lab, LoadFrame::body}) {
        scene.loads.push_back({.load = EndCouple{.end = {0, 2e-4, 1e-4}, .frame = frame}, .rods = {"crooked", "flat"}});
        scene.loads.push_back({.load = MuscleWave{.amplitude = 1e-3, .period = 0.5, .wavelength = 1, .frame = frame},
                               .rods = {"crooked", "flat"}});
    }
    for (const LoadFrame frame : {LoadFrame::lab, LoadFrame::body})
        scene.loads.push_back({.load = MuscleFormula{{"0", "1e-3*sin(9*t - 6*s)", "2e-4*s*cos(rod)"}, frame},
                               .rods = {"crooked", "flat"}});
    scene.loads.push_back(
        {.load = SinusoidalEndForce{.start = 0.01, .end = -0.02, .hold = 0.05, .period = 0.3}, .rods = {"flat"}});
    scene.loads.push_back({.load = SlenderBodyDrag{.viscosity = 0.02}, .rods = {"crooked", "flat"}});
    scene.loads.push_back(
        {.load =
             MuscleTorques{.coefficients = {0, 1e-3, 2e-3, 1e-3, 0}, .period = 0.4, .wave_number = 6, .ramp = {0.1}},
         .rods = {"crooked"}});
    scene.damping = {{.damping = {.kind = DampingKind::legacy, .rate = 0.5}, .rods = {"cilia"}},
                     {.damping = {.kind = DampingKind::laplacian, .rate = 20, .order = 2}, .rods = {"cilia", "flat"}},
                     {.damping = {.kind = DampingKind::uniform, .rate = 2}, .rods = {"crooked"}}};
    return scene;
}

std::uint64_t digest(int lanes, int threads, std::int64_t batch) {
    test::Stage stage(everything(), lanes, threads);
    stage.advance(300, batch);
    stage.rods->inspect(300, stage.plan.dt);
    return stage.rods->digest();
}

TEST(Bits, AreTheSameForEveryWidthThreadCountAndBatch) {
    const std::uint64_t one = digest(1, 1, 64);
    for (const int lanes : test::built_lanes())
        for (const int threads : {1, 2})
            for (const std::int64_t batch : {1, 7, 64})
                EXPECT_EQ(digest(lanes, threads, batch), one)
                    << lanes << " lanes, " << threads << " threads, batches of " << batch;
}

// Beyond half a radian lanes take the C library: neighbours that are turned against each other, and tops that spin
// fast.
TEST(Bits, AreTheSameWhereTurnsAreLarge) {
    if (const std::string reason = test::one_width(); !reason.empty()) GTEST_SKIP() << reason;
    RodSpec rod = test::simple_rod(10);
    rod.shape.start_curvature = Vec3d{12, 0, 3};
    rod.placement = {.kind = PlacementKind::line, .counts = {11}, .spacing = {3}};
    SceneSpec scene;
    scene.rods = {rod};
    scene.time = {.duration = 1};
    const auto digest = [&](int lanes) {
        test::Stage stage(scene, lanes);
        std::vector<Slot<1>> state(11);
        for (std::size_t i = 0; i < 11; i += 2) {
            stage.rods->export_rod(i, state);
            for (std::size_t k = 0; k < 10; ++k)
                set_lane(state[k].spin, 0, (1 / stage.plan.dt) * Vec3d{0.9, -0.4, 0.1});
            stage.rods->import_rod(i, state);
        }
        stage.advance(3);
        return stage.rods->digest();
    };
    for (const int lanes : test::other_lanes()) EXPECT_EQ(digest(lanes), digest(1)) << lanes << " lanes";
}

TEST(Bits, SurviveExportAndImport) {
    test::Stage whole(everything()), halves(everything());
    whole.advance(200);
    halves.advance(90);
    test::Stage resumed(everything(), 4);
    std::vector<Slot<1>> state;
    for (std::size_t i = 0; i < halves.rods->local().size(); ++i) {
        state.resize(static_cast<std::size_t>(nth(halves.groups, halves.rods->local()[i].group).slots()));
        halves.rods->export_rod(i, state);
        resumed.rods->import_rod(i, state);
    }
    resumed.clock = Clock(resumed.plan.dt, 90);
    resumed.advance(200);
    EXPECT_EQ(resumed.rods->digest(), whole.rods->digest());
}

TEST(Inspect, NamesRodElementAndQuantity) {
    test::Stage stage(test::cilia_scene(5));
    std::vector<Slot<1>> state(26);
    stage.rods->export_rod(3, state);
    set_lane(state[7].spin, 0, Vec3d{0, NAN, 0});
    const auto next = Clock(stage.plan.dt, 0).next(1);
    EXPECT_TRUE(stage.rods->advance(next, true));
    stage.rods->import_rod(3, state);
    EXPECT_FALSE(stage.rods->advance({}, true));
    try {
        stage.rods->inspect(42, 1e-3);
        FAIL() << "a NaN passed";
    } catch (const NumericalError& e) {
        const std::string text = e.what();
        for (const char* part : {"rod 3 of 'cilia'", "element 7", "angular velocity", "step 42"})
            EXPECT_NE(text.find(part), std::string::npos) << text;
    }
}

// A rod of ten, squeezed evenly more and more: told from 0.93 of the limit on, invalid from 1 on, at every width alike.
TEST(Inspect, NamesARodWhoseStrainsLeaveTheStepNoRoom) {
    for (const bool forced : {false, true})
        for (const int lanes : {1, 8}) {
            SceneSpec scene;
            RodSpec rod = test::simple_rod(10);
            rod.section.radius = 0.1;
            rod.placement = {.kind = PlacementKind::line, .counts = {10}, .spacing = {1}};
            scene.rods = {rod};
            scene.time = {.duration = 1, .force_dt = forced};
            scene.time.dt = 0.6 * 0.1 * std::sqrt(1000 / 1e6);
            test::Stage stage(scene, lanes);
            std::vector<Slot<1>> state(11);
            int told = 0, stopped = 0;
            for (const double e : {1.2, 1.0, 0.85, 0.82, 0.79, 0.77, 0.7, 0.6}) {
                stage.rods->export_rod(7, state);
                for (std::size_t k = 0; k < 11; ++k)
                    set_lane(state[k].position, 0,
                             stage.groups[0].origin(7) + Vec3d{0, 0, 0.1 * e * static_cast<double>(k)});
                stage.rods->import_rod(7, state);
                const double share =
                    0.5 * scene.time.dt * std::sqrt(largest_eigenvalue(test::tile_of(stage.groups[0], state))[0]);
                told += share > 0.93;
                stopped += share > 1;
                EXPECT_EQ(stage.rods->advance({}, true), forced || share <= 1) << e;
                const std::string near = stage.rods->near_limit();
                EXPECT_EQ(near.empty(), share <= 0.93) << e << near;
                if (near.empty()) continue;
                for (const char* part : {"rod 7 of 'rod'", "element ", " mode", "dilatation e = "})
                    EXPECT_NE(near.find(part), std::string::npos) << near;
                if (forced || share <= 1) {
                    EXPECT_NO_THROW(stage.rods->inspect(42, scene.time.dt));
                    continue;
                }
                try {
                    stage.rods->inspect(42, scene.time.dt);
                    FAIL() << "a step beyond its limit passed";
                } catch (const NumericalError& error) {
                    EXPECT_EQ(std::string(error.what()).find(near), 0u) << error.what();
                    EXPECT_NE(std::string(error.what()).find("step 42"), std::string::npos) << error.what();
                }
            }
            EXPECT_GT(stopped, 0);
            EXPECT_GT(told, stopped);
            EXPECT_LT(told, 6);
        }
}

} // namespace
} // namespace skein
