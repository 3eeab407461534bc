// Rods along tiles, in pieces or beside rods of other lengths, have the bits of rods across.
#include "loads/end_couple.hpp"
#include "loads/end_force.hpp"
#include "loads/formula_load.hpp"
#include "loads/gravity.hpp"
#include "loads/guide.hpp"
#include "loads/magnetic_formula.hpp"
#include "loads/muscle_formula.hpp"
#include "loads/muscle_torques.hpp"
#include "loads/muscle_wave.hpp"
#include "loads/plane_friction.hpp"
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

/// Rods of many lengths with all that strands can carry: sections, ends, tapers, loads, and dampings of three groups of
/// passes.
SceneSpec mixed(Law law, Integrator integrator = Integrator::verlet) {
    SceneSpec scene = test::cilia_scene(3, 12);
    scene.rods[0].material.law = law;
    scene.rods[0].shape.end_weights = EndWeights::gregory;
    scene.time = {.duration = 1, .safety = 0.5, .integrator = integrator};
    for (const long elements : {5, 6, 9, 17, 40}) {
        RodSpec rod = elements % 2 ? test::crooked_rod(elements) : test::simple_rod(elements);
        rod.name = "rod " + std::to_string(elements);
        rod.material.law = law;
        rod.start = elements == 9 ? EndKind::clamped : elements == 17 ? EndKind::pinned : EndKind::free;
        rod.end = elements == 5 ? EndKind::clamped : elements == 40 ? EndKind::clamped_frozen : EndKind::free;
        if (elements == 6)
            rod.shape.start_curvature =
                Vec3d{2.5, 0, 1}; // half a radian per cell: both sides of the polynomials' range
        if (elements == 6) rod.shape.end_weights = EndWeights::gregory;
        if (elements == 40) rod.placement = {.kind = PlacementKind::line, .counts = {2}, .spacing = {1}};
        scene.rods.push_back(rod);
    }
    RodSpec sliding = test::crooked_rod(23);
    sliding.name = "sliding";
    sliding.material.law = law;
    sliding.start = EndKind::clamped;
    sliding.end = EndKind::pinned;
    sliding.start_free = "xz";
    sliding.end_free = "y";
    scene.rods.push_back(sliding);
    sliding.name = "sliding too";
    sliding.shape.elements = 6;
    sliding.shape.length_profile.clear();
    sliding.start = EndKind::pinned;
    sliding.end = EndKind::clamped_frozen;
    scene.rods.push_back(sliding);
    // Reads the loads of all others, whichever comes first.
    PlaneFriction ground{.point = {0, 0, -0.02}, .stiffness = 10, .damping = 0.1, .tolerance = 1};
    ground.kinetic_forward = 0.3;
    ground.kinetic_backward = 0.4;
    ground.kinetic_sideways = 0.5;
    ground.static_forward = 0.5;
    ground.static_backward = 0.6;
    ground.static_sideways = 0.7;
    ground.slip_speed = 0.05;
    scene.loads.push_back({.load = ground, .rods = {"rod 6", "rod 9", "rod 17", "rod 40"}});
    scene.loads.push_back({.load = SlenderBodyDrag{.viscosity = 0.02}, .rods = {"rod 5", "rod 17", "rod 40"}});
    scene.loads.push_back({.load = Gravity{}});
    scene.loads.push_back({.load = UniformForce{.force = {0.01, 0, 0}}});
    scene.loads.push_back({.load = UniformCouple{.couple = {0, 1e-4, 0}}, .rods = {"rod 5", "rod 17"}});
    scene.loads.push_back({.load = EndForce{.start = {0, 0, 0.01}, .end = {0, 0.02, 0}, .ramp = {0.1}}});
    scene.loads.push_back({.load = EndForce{.start = {0, 0.01, 0}, .end = {0.01, 0, 0}, .frame = LoadFrame::body}});
    for (const LoadFrame frame : {LoadFrame::lab, LoadFrame::body}) {
        scene.loads.push_back(
            {.load = EndCouple{.start = {1e-4, 0, 0}, .end = {0, 2e-4, 1e-4}, .frame = frame, .ramp = {0.1}}});
        scene.loads.push_back({.load = MuscleWave{.amplitude = 1e-3, .period = 0.5, .wavelength = 1, .frame = frame},
                               .rods = {"rod 5", "rod 9", "sliding", "rod 6"}});
    }
    scene.loads.push_back({.load = Guide{.stiffness = 0.01, .along = "xz", .place = {"0.1*sin(9*t)", "0", "-0.4"}},
                           .rods = {"cilia", "rod 5", "rod 6", "rod 40"}});
    scene.loads.push_back(
        {.load = SinusoidalEndForce{.start = 0.01, .end = -0.02, .hold = 0.05, .period = 0.3}, .rods = {"rod 6"}});
    scene.loads.push_back(
        {.load =
             MuscleTorques{.coefficients = {0, 1e-3, 2e-3, 1e-3, 0}, .period = 0.4, .wave_number = 6, .ramp = {0.1}},
         .rods = {"rod 17"}});
    scene.tables.push_back({.name = "gust", .at = {0, 0.1, 0.3}, .value = {0, 1, 0.5}, .periodic = true});
    scene.loads.push_back(
        {.load = FormulaLoad{.force = {"1e-3*sin(20*t - 3*s)*x", "-0.01*vy*gust(t)", "1e-3*exp(-(1*z)^2)*rod/L"},
                             .couple = {"1e-6*x*vy", "1e-6*cos(9*t)*s", "1e-6*tanh(1*z)"}},
         .rods = {"cilia", "rod 5", "rod 40"}});
    scene.loads.push_back({.load = FormulaLoad{.force = {"0.01*(X - x)", "1e-3", "0"},
                                               .couple = {"0", "1e-6*y", "1e-6"},
                                               .at = FormulaAt::end,
                                               .frame = LoadFrame::body},
                           .rods = {"rod 9", "rod 40"}});
    scene.loads.push_back({.load = FormulaLoad{.force = {"1e-3", "0", "2e-3*cos(9*t)"}, .at = FormulaAt::start},
                           .rods = {"cilia", "rod 9"}});
    scene.loads.push_back({.load = FormulaLoad{.force = {"0.1*sin(9*t)", "0", "-0.3"},
                                               .couple = {"1e-6*gust(t)", "0", "1e-6"},
                                               .per = FormulaPer::mass},
                           .rods = {"cilia", "rod 40"}});
    scene.loads.push_back({.load = MagneticFormula{{"1e-3", "2e-3*sin(5*t)", "0"}}, .rods = {"cilia"}});
    scene.loads.push_back(
        {.load = MagneticFormula{{"1e-3*x*z", "2e-3*sin(5*t)", "1e-3*y*y - 1e-3*s"}}, .rods = {"cilia"}});
    scene.loads.push_back(
        {.load = MagneticFormula{{"1e-3*x*z", "2e-3", "1e-3*y"}, {"3*s/L", "1 + 1*rod", "sin(5*s)*2"}},
         .rods = {"rod 9", "rod 40"}});
    for (const LoadFrame frame : {LoadFrame::lab, LoadFrame::body}) {
        scene.loads.push_back({.load = MuscleFormula{{"1e-4*sin(9*t - 6*s)", "0", "1e-4*s*cos(rod)"}, frame},
                               .rods = {"cilia", "rod 5", "rod 9", "rod 40", "sliding"}});
        scene.loads.push_back(
            {.load = MuscleFormula{{"0", "1e-4*cos(9*t)", "1e-5"}, frame}, .rods = {"rod 6", "rod 17"}});
    }
    scene.damping = {{.damping = {.kind = DampingKind::legacy, .rate = 0.5}, .rods = {"cilia", "rod 5", "rod 6"}},
                     {.damping = {.kind = DampingKind::uniform, .rate = 2}, .rods = {"rod 40"}}};
    return scene;
}

/// Lengths alone differ: one family.
SceneSpec ladder(long most) {
    SceneSpec scene;
    scene.time = {.duration = 1};
    for (long elements = 5; elements <= most; ++elements) {
        RodSpec rod = test::simple_rod(elements);
        rod.name = "rod " + std::to_string(elements);
        rod.shape.length = 0.05 * static_cast<double>(elements);
        rod.start = EndKind::clamped;
        rod.end = elements % 3 ? EndKind::free : EndKind::clamped;
        if (elements % 2) rod.shape.end_weights = EndWeights::gregory;
        scene.rods.push_back(rod);
    }
    scene.loads.push_back({.load = Gravity{}});
    return scene;
}

/// The first number of any rod in which two stages differ.
std::string difference(const test::Stage& a, const test::Stage& b) {
    for (std::size_t i = 0; i < a.rods->local().size(); ++i) {
        const RodGroup& group = nth(a.groups, a.rods->local()[i].group);
        std::vector<Slot<1>> one(static_cast<std::size_t>(group.slots())), other(one.size());
        a.rods->export_rod(i, one);
        b.rods->export_rod(i, other);
        for (std::size_t k = 0; k < one.size(); ++k)
            for (int d = 0; d < slot_doubles; ++d) {
                const double x = reinterpret_cast<const double*>(&one[k])[d],
                             y = reinterpret_cast<const double*>(&other[k])[d];
                if (std::bit_cast<std::uint64_t>(x) != std::bit_cast<std::uint64_t>(y))
                    return group.name() + ", slot " + std::to_string(k) + ", number " + std::to_string(d) + ": " +
                           std::to_string(x) + ", " + std::to_string(y) + " less " + std::to_string(x - y);
            }
    }
    return {};
}

TEST(Mapping, GivesTheSameBits) {
    for (const Law law : test::energy_laws())
        for (const Integrator integrator : {Integrator::verlet, Integrator::pefrl}) {
            test::Stage across(mixed(law, integrator), 1);
            across.advance(300);
            across.rods->inspect(300, across.plan.dt);
            for (const int lanes : test::built_lanes({2, 4, 8}))
                for (const int threads : {1, 2})
                    for (const std::int64_t batch : {1, 64}) {
                        test::Stage along(mixed(law, integrator), lanes, threads, Mapping::along);
                        for (const GroupPlan& g : along.plan.groups) ASSERT_EQ(g.along, g.rods) << g.name;
                        along.advance(300, batch);
                        EXPECT_EQ(difference(across, along), "")
                            << lanes << " lanes, " << threads << " threads, batches of " << batch;
                        EXPECT_EQ(along.rods->digest(), across.rods->digest());
                    }
        }
}

TEST(Mapping, IsTriedWithEveryLoad) {
    const SceneSpec scene = mixed(Law::incompressible);
    for (int kind = 0; kind < static_cast<int>(load_kinds().size()); ++kind)
        EXPECT_TRUE(std::any_of(scene.loads.begin(), scene.loads.end(), [&](const LoadSpec& l) {
            return l.load.number() == kind;
        })) << nth(load_kinds(), kind);
}

TEST(Mapping, OfALadderOfLengths) {
    test::Stage across(ladder(40), 8, 1, Mapping::across), along(ladder(40), 8, 1, Mapping::along),
        automatic(ladder(40));
    EXPECT_EQ(along.plan.families, 1);
    EXPECT_GT(automatic.plan.groups[20].along, 0);
    for (test::Stage* stage : {&across, &along, &automatic}) stage->advance(200);
    EXPECT_EQ(difference(across, along), "");
    EXPECT_EQ(difference(across, automatic), "");
}

/// Sections that lie flat and upright turn as different tops, and share no tile.
TEST(Mapping, OfFlatAndUprightSections) {
    SceneSpec scene = ladder(12);
    for (std::size_t i = 0; i < scene.rods.size(); ++i) {
        const bool flat = i % 2 == 0;
        scene.rods[i].section = {
            .kind = SectionKind::elliptic, .radius = flat ? 0.02 : 0.01, .radius_2 = flat ? 0.01 : 0.02};
        scene.rods[i].shape.element_spin = {3, 2, 5};
    }
    test::Stage across(scene, 8, 1, Mapping::across), along(scene, 8, 1, Mapping::along);
    EXPECT_EQ(along.plan.families, 2);
    for (test::Stage* stage : {&across, &along}) stage->advance(100);
    EXPECT_EQ(difference(across, along), "");
}

TEST(Mapping, SurvivesExportAndImport) {
    test::Stage whole(mixed(Law::incompressible), 8, 1, Mapping::along),
        half(mixed(Law::incompressible), 8, 1, Mapping::along);
    whole.advance(200);
    half.advance(90);
    test::Stage resumed(mixed(Law::incompressible), 4, 2, Mapping::along);
    std::vector<Slot<1>> state;
    for (std::size_t i = 0; i < half.rods->local().size(); ++i) {
        state.resize(static_cast<std::size_t>(nth(half.groups, half.rods->local()[i].group).slots()));
        half.rods->export_rod(i, state);
        resumed.rods->import_rod(i, state);
    }
    resumed.clock = Clock(resumed.plan.dt, 90);
    resumed.advance(200);
    EXPECT_EQ(difference(whole, resumed), "");
}

TEST(Mapping, WatchesStepAndStateAlike) {
    test::Stage across(mixed(Law::incompressible), 1), along(mixed(Law::incompressible), 8, 1, Mapping::along);
    for (test::Stage* stage : {&across, &along}) {
        stage->advance(128);
        EXPECT_TRUE(stage->rods->advance({}, true));
    }
    for (std::size_t i = 0; i < across.rods->local().size(); ++i) {
        const auto slots = static_cast<std::size_t>(nth(across.groups, across.rods->local()[i].group).slots());
        std::vector<Slot<1>> good(slots);
        across.rods->export_rod(i, good);
        for (const std::size_t k : {std::size_t{0}, slots / 2, slots - 2, slots - 1}) {
            std::vector<Slot<1>> bad = good;
            set_lane(bad[k].position, 0, lane(bad[k].position, 0) + Vec3d{0, 0, 300});
            std::string told[2];
            int n = 0;
            for (test::Stage* stage : {&across, &along}) {
                stage->rods->import_rod(i, bad);
                EXPECT_FALSE(stage->rods->advance({}, true)) << i << ' ' << k;
                try {
                    stage->rods->inspect(128, stage->plan.dt);
                } catch (const NumericalError& error) {
                    told[n] = error.what();
                }
                ++n;
                stage->rods->import_rod(i, good);
                EXPECT_TRUE(stage->rods->advance({}, true));
            }
            EXPECT_FALSE(told[0].empty());
            EXPECT_EQ(told[0], told[1]);
        }
    }
}

TEST(Mapping, FindsTheSamePresentLimits) {
    SceneSpec scene = mixed(Law::incompressible);
    test::Stage across(scene, 1), probe(scene, 1);
    across.advance(128);
    // A step so close to its limit that one is told of it.
    scene.time.force_dt = true;
    scene.time.dt = 1.2 * across.plan.limit;
    std::string told[2];
    for (const bool along : {false, true}) {
        test::Stage stage(scene, along ? 8 : 1, 1, along ? Mapping::along : Mapping::across);
        std::vector<Slot<1>> state;
        for (std::size_t i = 0; i < across.rods->local().size(); ++i) {
            state.resize(static_cast<std::size_t>(nth(across.groups, across.rods->local()[i].group).slots()));
            across.rods->export_rod(i, state);
            stage.rods->import_rod(i, state);
        }
        stage.rods->advance({}, true);
        told[along] = stage.rods->near_limit();
    }
    EXPECT_FALSE(told[0].empty());
    EXPECT_EQ(told[0], told[1]);
}

} // namespace
} // namespace skein
