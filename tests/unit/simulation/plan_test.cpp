// Plans are what they are printed to be: snapshots for every scene in apps/, absent physics absent, steps within limits.
#include "core/error.hpp"
#include "scene/scene_file.hpp"
#include "simulation/make_rods_at.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

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
TEST(Plan, SnapshotOfEveryScene) {
    ASSERT_FALSE(app_scenes().empty());
    for (const fs::path& path : app_scenes()) {
        const SceneSpec scene = read_scene(path.string());
        const std::string text = to_text(make_plan(scene, make_groups(scene), {2, 1, 1, 8}));
        const fs::path snapshot = fs::path(SKEIN_SOURCE_DIR) / "tests/unit/simulation/plans" / (path.stem().string() + ".txt");
        if (std::getenv("SKEIN_UPDATE_SNAPSHOTS")) std::ofstream(snapshot) << text;
        EXPECT_EQ(text, text_of(snapshot)) << path << " against " << snapshot;
    }
}

TEST(Plan, NamesThePassesThatRun) {
    const SceneSpec scene = test::cilia_scene(3);
    const auto groups = make_groups(scene);
    const Plan plan = make_plan(scene, groups, {});
    const auto program = make_program<8>(plan.groups[0], groups[0], scheme_of(Integrator::verlet), plan.dt);
    ASSERT_EQ(program.size(), plan.groups[0].passes.size());
    for (std::size_t i = 0; i < program.size(); ++i) EXPECT_EQ(program[i]->name(), plan.groups[0].passes[i]);
}

TEST(Plan, NamesThePassesOfAnAudit) {
    SceneSpec scene = test::cilia_scene(3);
    scene.output.audit = true;
    scene.rods[0].end = EndKind::clamped;
    scene.rods[0].end_motion = {.amplitude = {0, 0, 0.01}, .period = 1};
    const auto groups = make_groups(scene);
    const Plan plan = make_plan(scene, groups, {});
    const auto program = make_program<8>(plan.groups[0], groups[0], scheme_of(Integrator::verlet), plan.dt, std::make_shared<AuditBook<8>>(groups[0]));
    ASSERT_EQ(program.size(), plan.groups[0].passes.size());
    for (std::size_t i = 0; i < program.size(); ++i) EXPECT_EQ(program[i]->name(), plan.groups[0].passes[i]);
}

TEST(Plan, HintsAtElementsThatGainNothing) {
    const auto hints = [](long elements, EndKind start) {
        const SceneSpec scene = test::cilia_scene(8, elements, start); // r = 0.15 m, L = 1.5 m
        return make_plan(scene, make_groups(scene), {}).groups[0].hints;
    };
    EXPECT_TRUE(hints(9, EndKind::clamped).empty());
    ASSERT_EQ(hints(25, EndKind::clamped).size(), 1u);
    EXPECT_NE(hints(25, EndKind::clamped)[0].find("elements = 10 would do"), std::string::npos) << hints(25, EndKind::clamped)[0];
    EXPECT_EQ(hints(9, EndKind::clamped_frozen).size(), 1u);
}

TEST(Plan, AbsentPhysicsHasNoPassAndNoArray) {
    SceneSpec bare = test::cilia_scene(8);
    bare.loads.clear();
    bare.damping.clear();
    bare.rods[0].magnetisation = {};
    const auto groups = make_groups(bare);
    const Plan plan = make_plan(bare, groups, {});
    const std::vector<std::string> expected = {"drift (circular)", "orthonormalise", "elastic (incompressible)", "kick"};
    EXPECT_EQ(plan.groups[0].passes, expected);
    EXPECT_EQ(plan.cadence.trajectory + plan.cadence.tips + plan.cadence.series + plan.cadence.checkpoint, 0);
    for (const char* absent : {"damping", "gravity", "magnetics", "muscles", "trajectory", "tips", "time series"})
        EXPECT_NE(std::find(plan.absent.begin(), plan.absent.end(), absent), plan.absent.end()) << absent;
    EXPECT_EQ(plan.output_bytes, 0);
    const auto program = make_program<8>(plan.groups[0], groups[0], scheme_of(Integrator::verlet), plan.dt);
    EXPECT_EQ(program.size(), expected.size());
}

TEST(Plan, ALoadActsOnlyOnTheGroupsItNames) {
    SceneSpec scene = test::cilia_scene(2);
    RodSpec other = test::simple_rod();
    other.name = "other";
    scene.rods.push_back(other);
    scene.loads.push_back({.load = Gravity{}, .rods = {"other"}});
    const Plan plan = make_plan(scene, make_groups(scene), {});
    EXPECT_EQ(plan.groups[0].loads.size(), 1u);
    EXPECT_EQ(plan.groups[1].loads.size(), 1u) << "gravity, but no couple on rods that are not magnetised";
    EXPECT_EQ(kind_of(plan.groups[1].loads[0]), "gravity");
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
        for (const char* part : {"cilia", "element", "shear-rotation", "force_dt"}) EXPECT_NE(text.find(part), std::string::npos) << text;
    }
    scene.time.force_dt = true;
    EXPECT_EQ(make_plan(scene, make_groups(scene), {}).dt, scene.time.dt);
}

} // namespace
} // namespace skein
