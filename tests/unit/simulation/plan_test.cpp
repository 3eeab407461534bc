// Plans are what they are printed to be: snapshots for every scene in apps/, absent physics absent, steps within
// limits.
#include "kernels/physics_passes.hpp"
#include "loads/formula_load.hpp"
#include "loads/gravity.hpp"
#include "loads/slender_body_drag.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "physics/loads/load_plan.hpp"
#include "plan/method_costs.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"
#include "support/scenes_for_tests.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <type_traits>

namespace skein {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
    std::stringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

std::vector<fs::path> app_scenes() {
    std::vector<fs::path> scenes;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SKEIN_SOURCE_DIR) / "apps"))
        if (entry.path().extension() == ".toml") scenes.push_back(entry.path());
    std::sort(scenes.begin(), scenes.end());
    return scenes;
}

// A changed plan is a decision: look at the difference, then run with SKEIN_UPDATE_SNAPSHOTS=1 to accept it.
void compare_with_snapshot(const fs::path& path, const Machine& machine) {
    const SceneSpec scene = read_scene(path.string());
    const std::string text = to_text(make_plan(scene, make_whole_groups(scene), machine));
    const fs::path snapshot =
        fs::path(SKEIN_SOURCE_DIR) / "tests/unit/simulation/plans" / (path.stem().string() + ".txt");
    if (std::getenv("SKEIN_UPDATE_SNAPSHOTS")) std::ofstream(snapshot) << text;
    EXPECT_EQ(text, text_of(snapshot)) << path << " against " << snapshot;
}

TEST(Plan, SnapshotOfEveryScene) {
    ASSERT_FALSE(app_scenes().empty());
    for (const fs::path& path : app_scenes()) compare_with_snapshot(path, {2, 1, 1, 8});
}

/// Without its notes, unless all lines are asked for.
TEST(Plan, HasAtMostTenLines) {
    for (const fs::path& path : app_scenes()) {
        const SceneSpec scene = read_scene(path.string());
        Plan plan = make_plan(scene, make_whole_groups(scene), {2, 1, 1, 8});
        plan.notes.clear();
        for (GroupPlan& group : plan.groups) { // what a file of points or a poor choice adds
            group.hints.clear();
            group.deviation = {};
        }
        const std::string text = to_text(plan, false);
        EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 10) << path << "\n" << text;
        EXPECT_GT(to_text(plan).size(), text.size()) << path;
    }
}

TEST(Plan, TellsWhichMethodPays) {
    const auto text = [](double by_explicit, double by_implicit) {
        Plan plan;
        plan.methods = std::make_shared<const MethodCosts>(
            MethodCosts{{Integrator::verlet, by_explicit, 2e-12}, {Integrator::implicit_damped, by_implicit, 1e-3}});
        return to_text(plan, false);
    };
    const auto expect = [](const std::string& all, const std::string& part) {
        EXPECT_NE(all.find(part), std::string::npos) << all;
    };
    expect(text(1800, 3.1),
           "  method        implicit steps pay: \"verlet\" takes about 30 min at an error below 1e-09 of "
           "the length, \"implicit_damped\" about 3 s at an error of 0.001 of the length\n");
    expect(text(5, 20), "explicit steps pay: \"verlet\" takes about 5 s");
    expect(text(5, 5), "explicit steps pay");
    expect(text(5, 3), "neither method pays");
    expect(text(5, 2.4), "implicit steps pay");
    expect(text(5, HUGE_VAL), "explicit steps pay");
    expect(text(5, HUGE_VAL), "\"implicit_damped\" longer\n");
    EXPECT_EQ(to_text(Plan{}, false).find("method"), std::string::npos);
}

TEST(Plan, SnapshotOfALargeFluidOnNodes) {
    compare_with_snapshot(fs::path(SKEIN_SOURCE_DIR) / "tests/unit/simulation/large_fluid.toml",
                          {.ranks = 32, .threads = 16, .cores = 16, .cores_per_node = 128});
}

/// Steps of a fluid, and where the speed is from that they are predicted from.
TEST(Plan, PredictsStepsOfAFluidFromWhatIsFastest) {
    SceneSpec scene;
    scene.time = {.duration = 2, .dt = 0.5};
    scene.fluid = FluidSpec{.cells = {16, 16, 16}, .spacing = 0.125, .density = 1, .viscosity = 1e-6, .courant = 0.5};
    const auto expect = [&](double steps, double speed, const std::string& by) {
        const Plan plan = make_plan(scene, {}, {});
        EXPECT_EQ(plan.find<FluidPlan>()->steps(plan.steps, plan.dt), steps) << by;
        EXPECT_NEAR(plan.find<FluidPlan>()->speed.value, speed, 1e-12) << by;
        EXPECT_EQ(plan.find<FluidPlan>()->speed.by, by);
        EXPECT_NEAR(plan.predicted_s, steps * plan.find<FluidPlan>()->ns_per_cell_step() * 1e-9 * 4096, 1e-12);
        EXPECT_EQ(to_text(plan).find("at least") == std::string::npos, speed > 0);
    };
    expect(4, 0, "");
    scene.fluid->along_x = FluidBoundary::through;
    scene.fluid->inflow = {0.75, 0.25, 0};
    expect(4 * 8, 1, "the inflow"); // steps of at most 0.0625 s
    scene.fluid->along_z = FluidBoundary::no_slip;
    scene.fluid->upper_wall_velocity = {1.25, 0.25, 0};
    expect(4 * 12, 1.5, "a moving wall");
    scene.fluid->acceleration = {0, 0, 4 * std::numbers::pi};
    scene.fluid->frequency = 1;
    expect(4 * 20, 2, "the acceleration"); // steps of at most a fortieth of a period
    scene.fluid->frequency = 0;
    scene.fluid->upper_wall_velocity = {0, 0, 0};
    scene.obstacles = {{.radius = 0.2, .velocity = {-2, 0, 0}}};
    expect(4 * 16, 2, "an obstacle");
    scene.fluid->velocity_formula = {"U", "U", "0*U"};
    scene.constants = {{"U", 2, "m/s"}};
    expect(4 * 32, 4, "the velocity at the start");
    scene.fluid->expected_speed = 0.5;
    expect(4 * 4, 0.5, "fluid.expected_speed");
    scene.fluid->viscosity = 1; // sets steps of 2.5/12/1.5 h^2/nu = 2.17e-3 s
    expect(4 * 231, 0.5, "fluid.expected_speed");
    scene.fluid->scheme = FlowScheme::crank_nicolson; // for which viscosity sets none
    expect(4 * 4, 0.5, "fluid.expected_speed");
}

/// What docs/performance.md says of pencils.
TEST(Plan, TellsWhatRanksSendThatShareTheRowsOfSlabs) {
    SceneSpec scene = read_scene((fs::path(SKEIN_SOURCE_DIR) / "tests/unit/simulation/large_fluid.toml").string());
    const auto expect = [&](int ranks, int across, const std::string& told) {
        scene.fluid->ranks_across = across;
        const std::string text = to_text(make_plan(scene, {}, {.ranks = ranks}));
        EXPECT_NE(text.find(told), std::string::npos) << text;
    };
    expect(32, 4,
           "8 slabs of planes, the rows of each on 4 ranks; by a rank in a step: 319 MB in transposes (319 MB a "
           "solve), 83.6 MB as");
    expect(160, 0, "    sent        by a rank in a step: 39.1 MB in transposes (39.1 MB a solve), 216 MB as ghosts");
    expect(160, 8, "71.8 MB in transposes (71.8 MB a solve), 38.8 MB as ghosts");
    expect(320, 0, "19.6 MB in transposes (19.6 MB a solve), 216 MB as ghosts");
    expect(320, 16, "37.1 MB in transposes (37.1 MB a solve), 25.3 MB as ghosts");
    expect(640, 0,
           "320 slabs of planes, the rows of each on 2 ranks; by a rank in a step: 14.7 MB in transposes (14.7 MB a "
           "solve), 109 MB");
    expect(640, 16, "18.8 MB in transposes (18.8 MB a solve), 19.4 MB as ghosts");
    expect(1280, 0, "8.59 MB in transposes (8.59 MB a solve), 54.8 MB as ghosts");
    expect(1280, 32, "9.55 MB in transposes (9.55 MB a solve), 12.7 MB as ghosts");
    expect(1280, 32, "112 B per cell");
    expect(641, 0, "too few for 641 ranks: expected at most 320 slabs of planes times at most 320 ranks of each");
    expect(640, 3, "640 ranks cannot form slabs of 3 ranks each: expected a divisor of 640");
}

/// The plan that docs/tour.md explains, line by line, in blocks of code.
TEST(Plan, IsThatOfTheTour) {
    const SceneSpec scene = read_scene((fs::path(SKEIN_SOURCE_DIR) / "apps/cilia_carpet/row_8.toml").string());
    std::ifstream page(fs::path(SKEIN_SOURCE_DIR) / "docs/tour.md");
    std::string told;
    bool in_section = false, in_block = false;
    for (std::string line; std::getline(page, line);) {
        if (line.starts_with("## ")) in_section = line.starts_with("## 3 ");
        else if (in_section && line.starts_with("```")) in_block = !in_block;
        else if (in_section && in_block) told += line + "\n";
    }
    EXPECT_EQ(told, to_text(make_plan(scene, make_whole_groups(scene), {1, 2, 2, 8})));
}

/// Names of all kinds of passes, in the order of a step, without what tells variants apart.
template <class... Kinds> std::vector<std::string> kinds_of_passes(PassKindList<Kinds...>) {
    const auto name = []<class Kind>(std::type_identity<Kind>) -> std::string {
        if constexpr (std::is_same_v<Kind, pass::ApplyLoad>) return "each load";
        else return std::string(pass_of(PassPlace::drift, Kind{}).name);
    };
    std::vector<std::string> names = {name(std::type_identity<Kinds>{})...};
    for (std::string& one : names) one = one.substr(0, one.find(" ("));
    return names;
}

TEST(Plan, PassesStandInTheTableOfTheArchitecture) {
    std::ifstream page(fs::path(SKEIN_SOURCE_DIR) / "docs/design.md");
    std::vector<std::string> told;
    bool in_table = false;
    for (std::string line; std::getline(page, line);) {
        if (line.starts_with("| pass |")) in_table = true;
        else if (!line.starts_with("|")) in_table = false;
        else if (in_table && !line.starts_with("|---")) told.push_back(line.substr(2, line.find(" |", 2) - 2));
    }
    EXPECT_EQ(told, kinds_of_passes(PassKinds{}));
}

/// The passes that rods run are those of the plan.
void expect_planned_passes(SceneSpec scene) {
    const test::Stage stage(std::move(scene), 8, 1, Mapping::across);
    for (std::size_t g = 0; g < stage.groups.size(); ++g)
        EXPECT_EQ(stage.rods->passes(g), stage.plan.groups[g].program.names());
}

TEST(Plan, NamesThePassesThatRun) { expect_planned_passes(test::cilia_scene(3)); }

TEST(Plan, NamesThePassesOfAnAudit) {
    SceneSpec scene = test::cilia_scene(3);
    scene.output.audit = true;
    scene.rods[0].end = EndKind::clamped;
    scene.rods[0].end_motion = {.amplitude = {0, 0, 0.01}, .period = 1};
    expect_planned_passes(scene);
}

/// A rod on springs that are written as a formula.
SceneSpec on_springs(double per_mass, double dt = 0) {
    SceneSpec scene;
    scene.time = {.duration = 1, .dt = dt, .force_dt = dt > 0};
    scene.rods = {test::simple_rod()};
    scene.rods[0].placement.origin = {0.1, 0, 0};
    if (per_mass > 0) {
        scene.constants = {{"k", per_mass, "1/s^2"}};
        scene.loads = {{.load = FormulaLoad{.force = {"-k*x", "0", "0"}, .per = FormulaPer::mass}}};
    }
    return scene;
}

TEST(Plan, CountsTheStiffnessOfFormulas) {
    const auto limit = [](double per_mass) {
        const SceneSpec scene = on_springs(per_mass);
        return make_plan(scene, make_groups(scene), {}).groups[0].limits.front();
    };
    const double alone = limit(0).dt, fastest = 4 / (alone * alone);
    for (const double share : {0.1, 1.0, 400.0}) {
        EXPECT_EQ(limit(share * fastest).mode, "loads by formula");
        EXPECT_NEAR(limit(share * fastest).dt, alone / std::sqrt(1 + share), 1e-12 * alone);
    }
    EXPECT_NE(limit(1e-6 * fastest).mode, "loads by formula");

    // Springs so stiff that they alone set the limit: it is sharp.
    const double k = 400 * fastest;
    const auto farthest = [&](double share) {
        test::Stage stage(on_springs(k, share * limit(k).dt), 1, 1, Mapping::across);
        stage.advance(200);
        double most = 0;
        for (const Slot<1>& slot : stage.state(0)) most = std::max(most, std::abs(lane(slot.position, 0).x));
        return most;
    };
    EXPECT_LT(farthest(0.97), 1);
    EXPECT_FALSE(farthest(1.02) < 1e10);
}

TEST(Plan, PredictsWhatFormulasTake) {
    const auto ns = [](const std::string& x) {
        SceneSpec spec = test::cilia_scene(3);
        spec.loads = {{.load = FormulaLoad{.force = {x, "0", "0"}}}};
        return make_plan(spec, make_groups(spec), {}).groups[0].ns_per_element_step;
    };
    const double uniform = ns("3"), in_time = ns("3*sin(t)");
    EXPECT_EQ(in_time, uniform) << "worked out once a step";
    EXPECT_GT(ns("2*x + 2"), uniform);
    EXPECT_GT(ns("sin(2*x) + 2"), ns("2*x + 2") + 0.5);
    EXPECT_GT(ns("tanh(2*x) + 2"), ns("sin(2*x) + 2") + 0.5);
    EXPECT_GT(ns("x^2.3 + 2"), ns("tanh(2*x) + 2") + 1);
}

TEST(Plan, HintsAtElementsThatGainNothing) {
    const auto hints = [](long elements, EndKind start) {
        const SceneSpec scene = test::cilia_scene(8, elements, start); // r = 0.15 m, L = 1.5 m
        return make_plan(scene, make_groups(scene), {}).groups[0].hints;
    };
    EXPECT_TRUE(hints(9, EndKind::clamped).empty());
    ASSERT_EQ(hints(25, EndKind::clamped).size(), 1u);
    EXPECT_NE(hints(25, EndKind::clamped)[0].find("elements = 10 would do"), std::string::npos)
        << hints(25, EndKind::clamped)[0];
    EXPECT_EQ(hints(9, EndKind::clamped_frozen).size(), 1u);
}

TEST(Plan, TellsWhereLawsDiffer) {
    const auto hints = [](const Vec3d& rest, const Vec3d& start, Law law = Law::incompressible) {
        SceneSpec scene;
        scene.rods = {test::simple_rod(20)}; // r = 0.02 m
        scene.rods[0].material.law = law;
        scene.rods[0].shape.rest_curvature = rest;
        scene.rods[0].shape.start_curvature = start;
        scene.time.duration = 1;
        return make_plan(scene, make_groups(scene), {}).groups[0].hints;
    };
    EXPECT_TRUE(hints({0, 2.4, 0}, {2, 0, 2.4}).empty()) << "r kappa = 0.048";
    for (const auto& found : {hints({6, 8, 0}, {0, 0, 0}), hints({0, 0, 0}, {10, 0, 0}, Law::neo_hookean)}) {
        ASSERT_EQ(found.size(), 1u);
        EXPECT_EQ(
            found[0],
            "r kappa reaches 0.2 in bending and 0 in twist; from straight to that a free rod gets longer by 1.5 % with "
            "\"incompressible\", 1.5 % with \"neo_hookean\" and not at all with \"linear\": theory.md (11a)");
    }
    const auto twisted = hints({0, 0, 0}, {0, 0, -15}); // (r kappa)^2/4 and a third of that
    ASSERT_EQ(twisted.size(), 1u);
    EXPECT_NE(twisted[0].find("0 in bending and 0.3 in twist"), std::string::npos) << twisted[0];
    EXPECT_NE(twisted[0].find("2.2 % with \"incompressible\", 0.75 % with"), std::string::npos) << twisted[0];
    EXPECT_TRUE(hints({0, 0, 0}, {0, 0, 15}, Law::elastica).empty());
}

TEST(Plan, HintsAtElementsThatSeeNoBend) {
    const auto hints = [](double radius) {
        SceneSpec scene = test::cilia_scene(1, 5, EndKind::clamped);
        scene.rods[0].section.radius = radius;
        return make_plan(scene, make_groups(scene), {}).groups[0].hints;
    };
    EXPECT_TRUE(hints(0.3 / 900).empty());
    ASSERT_EQ(hints(0.3 / 2000).size(), 1u);
    EXPECT_NE(hints(0.3 / 2000)[0].find("2e+03 radii long"), std::string::npos) << hints(0.3 / 2000)[0];
}

/// Every interval a whole number of steps, where they have a common divisor that is no burden; else a note.
TEST(Plan, AutomaticStepDividesTheIntervalsOfAllOutputs) {
    const auto plan_of = [](const OutputSpec& output) {
        SceneSpec scene = test::cilia_scene(1);
        scene.output = output;
        return make_plan(scene, make_groups(scene), {});
    };
    const double limit = plan_of({}).limit;
    for (const auto& [trajectory, series] : {std::pair{50.0, 20.0}, {30.0, 45.0}, {70.0, 33.0}, {20.0, 50.0}}) {
        const Plan plan =
            plan_of({.trajectory = trajectory * limit, .series = series * limit, .checkpoint = 100 * limit});
        const bool alike = trajectory != 70;
        for (const double interval : {trajectory, series}) {
            const double steps = interval * limit / plan.dt;
            if (alike) {
                EXPECT_NEAR(steps, std::round(steps), 1e-9) << interval;
            }
        }
        EXPECT_EQ(plan.notes.empty(), alike) << trajectory;
        if (!alike) {
            EXPECT_NE(plan.notes[0].find("time.divide"), std::string::npos) << plan.notes[0];
        }
    }
    SceneSpec scene = test::cilia_scene(1);
    scene.output.series = 3.5 * limit;
    scene.time.dt = 0.5 * limit;
    EXPECT_TRUE(make_plan(scene, make_groups(scene), {}).notes.empty());
    scene.time.dt = 0.4 * limit;
    EXPECT_EQ(make_plan(scene, make_groups(scene), {}).notes.size(), 1u);
}

TEST(Plan, RefusesALimitThatIsNoStep) {
    for (const double youngs_modulus : {1e308, 1e-308}) {
        SceneSpec scene = test::cilia_scene(1);
        scene.rods[0].material.youngs_modulus = youngs_modulus;
        scene.rods[0].material.shear_modulus = youngs_modulus;
        scene.rods[0].section.radius = youngs_modulus > 1 ? 1e-3 : 1e-90;
        try {
            make_plan(scene, make_groups(scene), {});
            FAIL() << "accepted " << youngs_modulus;
        } catch (const InputError& e) {
            EXPECT_NE(std::string(e.what()).find("the limit of the time step is"), std::string::npos) << e.what();
        }
    }
}

TEST(Plan, TellsScaledRotaryInertiaAndWhatItCosts) {
    SceneSpec scene = test::cilia_scene(8);
    EXPECT_EQ(to_text(make_plan(scene, make_groups(scene), {})).find("inertia"), std::string::npos);
    scene.rods[0].material.rotary_inertia_scale = 25;
    const Plan plan = make_plan(scene, make_groups(scene), {});
    EXPECT_EQ(plan.groups[0].least_rotary_scale, 25);
    EXPECT_LT(plan.groups[0].bending_shift, 0);
    EXPECT_NE(to_text(plan).find("inertia about d1 and d2 times 25, which shifts the lowest bending frequency by -"),
              std::string::npos)
        << to_text(plan);
}

TEST(Plan, AbsentPhysicsHasNoPassAndNoArray) {
    SceneSpec bare = test::cilia_scene(8);
    bare.loads.clear();
    bare.damping.clear();
    bare.rods[0].magnetisation = {};
    const auto groups = make_groups(bare);
    const Plan plan = make_plan(bare, groups, {});
    const std::vector<std::string_view> expected = {"drift (circular)", "orthonormalise", "elastic (incompressible)",
                                                    "kick"};
    EXPECT_EQ(plan.groups[0].program.names(), expected);
    for (const auto& [name, every] : plan.cadence.steps) EXPECT_EQ(every, 0) << name;
    EXPECT_EQ(plan.output_bytes, 0);
    expect_planned_passes(bare);
}

TEST(Plan, ALoadActsOnlyOnTheGroupsItNames) {
    SceneSpec scene = test::cilia_scene(2);
    RodSpec other = test::simple_rod();
    other.name = "other";
    scene.rods.push_back(other);
    scene.loads.push_back({.load = Gravity{}, .rods = {"other"}});
    const Plan plan = make_plan(scene, make_groups(scene), {});
    const LoadPlan& loads = *plan.find<LoadPlan>();
    EXPECT_EQ(loads.of_group[0].size(), 1u);
    ASSERT_EQ(loads.of_group[1].size(), 1u) << "gravity, but no couple on rods that are not magnetised";
    EXPECT_EQ(loads.loads[loads.of_group[1][0]].kind(), "gravity");
}

TEST(Plan, AutomaticStepOfUndampedBodiesAndRodsIsShorter) {
    for (const bool body : {true, false})
        for (const bool damped : {false, true}) {
            SceneSpec scene;
            scene.time = {.duration = 1};
            scene.rods = {body ? test::rigid_body(0, 0.02) : test::simple_rod()};
            scene.rods[0].placement.origin = {0, 0, 1};
            scene.walls = {{.name = "floor", .law = {.stiffness = 1e5}}};
            if (damped) scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 1}}};
            const Plan plan = make_plan(scene, make_groups(scene), {});
            EXPECT_LE(plan.dt, (damped ? 0.855 : 0.6) * plan.limit);
            EXPECT_GT(plan.dt, (damped ? 0.6 : 0.5) * plan.limit) << body;
        }
}

TEST(Plan, AutomaticStepDividesTheMostFrequentOutput) {
    SceneSpec scene = test::cilia_scene(1);
    scene.output.tips = 0.36;
    const Plan plan = make_plan(scene, make_groups(scene), {});
    EXPECT_NEAR(std::round(0.36 / plan.dt) * plan.dt, 0.36, 1e-14);
    EXPECT_LE(plan.dt, 0.9 * 0.95 * plan.limit);
    EXPECT_EQ(plan.steps, std::llround(7.2 / plan.dt));
}

TEST(Plan, RefusesAStepBeyondTheLimitUnlessForced) {
    SceneSpec scene = test::cilia_scene(1);
    const double limit = make_plan(scene, make_groups(scene), {}).limit;
    scene.time.dt = 1.01 * limit;
    try {
        make_plan(scene, make_groups(scene), {});
        FAIL() << "accepted";
    } catch (const InputError& e) {
        const std::string text = e.what();
        for (const char* part : {"cilia", "element", "shear-rotation", "force_dt"})
            EXPECT_NE(text.find(part), std::string::npos) << text;
    }
    scene.time.force_dt = true;
    EXPECT_EQ(make_plan(scene, make_groups(scene), {}).dt, scene.time.dt);
}

/// A rod in so thick a fluid that drag governs the step, shaken.
SceneSpec dragged(Integrator integrator, double viscosity) {
    SceneSpec scene;
    scene.rods = {test::simple_rod(8)};
    scene.time = {.duration = 1, .integrator = integrator};
    scene.loads = {{.load = SlenderBodyDrag{.viscosity = viscosity}}};
    return scene;
}

TEST(Plan, CountsExplicitDragAmongTheLimits) {
    const auto limits = [](double viscosity) {
        const SceneSpec scene = dragged(Integrator::verlet, viscosity);
        return make_plan(scene, make_groups(scene), {}).groups[0].limits;
    };
    const auto thin = limits(1e-3), thick = limits(300);
    EXPECT_NE(thin.front().mode, "slender-body drag");
    ASSERT_EQ(thick.front().mode, "slender-body drag");
    // Inside, a node of mass m is dragged by one element's worth: nu = 4 pi mu l/(m ln(L/r)), and (h/h0)^2 + h nu/2
    // = 1.
    const double rate = 4 * 3.14159265358979324 * 300 / (1000 * 3.14159265358979324 * 0.02 * 0.02 * std::log(1 / 0.02));
    const double share = thick[0].dt / thick[1].dt;
    EXPECT_NEAR(share * share + thick[0].dt * rate / 2, 1, 1e-12);
    EXPECT_EQ(thick[1].dt, thin[0].dt);

    SceneSpec scene = dragged(Integrator::verlet, 300);
    scene.time.dt = 1.01 * thick[0].dt;
    try {
        make_plan(scene, make_groups(scene), {});
        FAIL() << "accepted";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("slender-body drag"), std::string::npos) << e.what();
    }
}

TEST(Plan, LimitOfExplicitDragIsSharp) {
    for (const Integrator integrator : {Integrator::verlet, Integrator::pefrl}) {
        SceneSpec scene = dragged(integrator, 3000);
        const double limit = make_plan(scene, make_groups(scene), {}).limit;
        for (const double share : {0.97, 1.2}) {
            scene.time.dt = share * limit;
            scene.time.force_dt = true;
            test::Stage stage(scene);
            stage.rods->import_rod(0, test::shaken_state(stage.groups[0], 1e-6, 1e-6, 1e-3));
            stage.advance(400);
            bool calm = true;
            for (const Slot<1>& s : stage.state(0)) calm &= norm(lane(s.velocity, 0)) < 1; // false for NaN
            EXPECT_EQ(calm, share < 1) << "share " << share;
        }
    }
}

TEST(Plan, WritesSmallScenesAsPolyDataByItself) {
    SceneSpec scene = test::cilia_scene(10, 25);
    const auto writes = [&](ParaView choice, long count) {
        scene.output.paraview = choice;
        scene.rods[0].placement.counts = {count};
        return make_plan(scene, make_groups(scene), {}).vtp;
    };
    EXPECT_FALSE(writes(ParaView::vtp, 10)) << "without a trajectory";
    scene.output.trajectory = 0.72;
    EXPECT_TRUE(writes(ParaView::automatic, 100000 / 26));
    EXPECT_FALSE(writes(ParaView::automatic, 100000 / 26 + 1));
    EXPECT_TRUE(writes(ParaView::vtp, 100000 / 26 + 1));
    EXPECT_FALSE(writes(ParaView::xdmf, 10));
    EXPECT_FALSE(writes(ParaView::none, 10));
}

TEST(Plan, CountsFramesThatWait) {
    SceneSpec scene = test::cilia_scene(10);
    const auto bytes = [&](int ranks) { return make_plan(scene, make_groups(scene), {ranks, 1, 1, 8}).frame_bytes; };
    EXPECT_EQ(bytes(1), 0);
    scene.time.dt = 0.0045;
    scene.output.tips = 0.45; // 17 frames of 10 rods, 3 numbers each
    EXPECT_EQ(bytes(1), 17 * 10 * 3 * 4);
    scene.output.trajectory = 0.0045; // 1601 frames of 10 rods, 26 nodes and 25 elements: 32 MB hold many, not all
    const double frame = 10 * 4 * (26 * 3 + 25 * 9 + 26 * 3), one = bytes(1), four = bytes(4);
    EXPECT_LE(one, (32 << 20) + 17 * 10 * 3 * 4);
    EXPECT_EQ(one, std::min(1601.0, std::floor((32 << 20) / frame)) * frame + 17 * 10 * 3 * 4);
    EXPECT_GE(four, one);
}

} // namespace
} // namespace skein
