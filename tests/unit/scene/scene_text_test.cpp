// Text that `skein describe scene.toml` prints: a scene, and the same one.
#include "physics/plan_input.hpp"
#include "plan/doubts.hpp"
#include "plan/plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene_fixture.hpp"

#include <gtest/gtest.h>

namespace skein {
namespace {

TEST(SceneText, ReadsBackAsTheSameScene) {
    ASSERT_GT(all_scenes().size(), 8u);
    for (const std::string& file : all_scenes()) {
        const SceneSpec scene = read_scene(file);
        for (const Keys which : {Keys::given, Keys::all}) {
            const std::string text = scene_toml(scene, which);
            EXPECT_EQ(scene_json(parse_scene(file, text), false), scene_json(scene, false)) << file << "\n" << text;
        }
    }
}

TEST(SceneText, KeepsTextsAndNumbersToTheLastBit) {
    SceneSpec scene = read_scene(good_scene);
    scene.title = "a \"quoted\" title \\ with\ttwo\nlines";
    scene.time.duration = 1000 * (0.1 + 0.2);
    scene.rods[0].placement.origin = {1e-300, -1.0 / 3, 5e-324};
    for (const Keys which : {Keys::given, Keys::all})
        EXPECT_EQ(scene_json(parse_scene("again", scene_toml(scene, which)), false), scene_json(scene, false));
}

TEST(SceneText, NamesEveryKeyWithItsUnit) {
    const std::string text = scene_toml(read_scene(good_scene), Keys::all);
    for (const char* line :
         {"\nduration = 216  # [s] time to simulate\n", "\n# rest_speed = 0  # [m/s]", "\n[[rods]]\n",
          "\n[rods.material]\n", "\n# [rods.hold]\n", "\n[[load]]\nkind = \"magnetic_field\"", "\n# normal =   # "})
        EXPECT_NE(text.find(line), std::string::npos) << line << "\n" << text;
}

/// Of rods, and of tables of loads, joints and walls.
std::vector<std::string> all_doubts(const SceneSpec& scene) {
    const std::vector<RodGroup> groups = make_groups(scene);
    std::vector<std::string> all = doubts(scene, groups, 1e-3);
    PlannedPhysics physics;
    LoadTables::plan({scene, scene, groups}, physics);
    JointTables::plan({scene, scene, groups}, physics);
    WallTables::plan({scene, scene, groups}, physics);
    for (const auto& one : physics.take())
        for (std::string& doubt : one->notes({}, groups)) all.push_back(std::move(doubt));
    return all;
}
std::string doubts_of(const std::vector<std::string>& overrides) {
    std::string all;
    for (const std::string& doubt : all_doubts(read_scene(good_scene, overrides))) all += doubt + "\n";
    return all;
}

TEST(Doubts, NoneOfShippedScenes) {
    for (const std::string& file : all_scenes()) {
        const auto found = all_doubts(read_scene(file));
        EXPECT_TRUE(found.empty()) << file << ": " << found.front();
    }
}

TEST(Doubts, OfNumbersFarFromTheirNeighbours) {
    EXPECT_EQ(doubts_of({}), "");
    const auto expect = [](const std::string& override, const std::string& said) {
        EXPECT_NE(doubts_of({override}).find(said), std::string::npos) << override << ": " << doubts_of({override});
    };
    expect("rods.cilia.material.density=1e18", "nothing will be seen to move");
    expect("rods.cilia.material.shear_modulus=2", "youngs_modulus is 9e+04 times shear_modulus");
    expect("rods.cilia.material.shear_modulus=1e12", "youngs_modulus is 2e-07 times shear_modulus");
    expect("load.magnetic_field.ramp=1e308", "load.0.ramp = 1e+308 s is");
    expect("rods.cilia.shape.velocity=[1e20, 0, 0]", "rods.cilia.shape.velocity = 1e+20 m/s is");
    expect("rods.wires.shape.rest_curvature_profile=[[0, 0, 7.5], [0, 1, 0]]",
           "the rest curvature turns element 1 against element 0 by 2.5 rad; at 3 rad a run stops, and up to 1 rad "
           "cells follow a "
           "bend: elements = 8 would do");
    expect("time.duration=1e13", "time.duration = 1e+13 s is 1e+16 steps");
}

TEST(Doubts, OfWallsThatAreTooFast) {
    SceneSpec scene = read_scene(good_scene);
    scene.walls = {{.name = "floor", .velocity = {1e20, 0, 0}}};
    const std::vector<std::string> found = all_doubts(scene);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NE(found[0].find("wall.floor.velocity = 1e+20 m/s is"), std::string::npos) << found[0];
}

TEST(Doubts, OfEndsThatJumpAsTheirMotionBegins) {
    const auto told = [](const std::vector<std::string>& overrides, const std::string& said) {
        const std::string all = doubts_of(overrides);
        EXPECT_EQ(all.find(said) != std::string::npos, true) << all;
    };
    const std::string moved = "rods.cilia.start_motion.translation_formula=[\"0.002*cos(2*t)\", \"0\", \"0\"]",
                      begins = "rods.cilia.start_motion.translation_formula=[\"0.002*sin(2*t)\", \"0\", \"0\"]",
                      turned = "rods.cilia.start_motion.rotation_formula=[\"0.03 + 2*t\", \"0\", \"0\"]";
    told({moved}, "rods.cilia.start_motion: the displacement is 0.002 m at t = 0");
    told({turned}, "rods.cilia.start_motion: the rotation is 0.03 rad at t = 0");
    EXPECT_EQ(doubts_of({begins}), "");
}

/// Published friction with a slip speed that its step does not follow; regularised friction follows any, and memory has
/// none.
TEST(Doubts, OfSlipThatTrembles) {
    const auto notes = [](const std::vector<std::string>& overrides) {
        const SceneSpec scene = read_scene(SHIPPED_SCENES "/contact/incline.toml", overrides);
        std::string all;
        for (const std::string& note : make_plan(scene, make_groups(scene), Machine{}).notes) all += note + "\n";
        return all;
    };
    const auto expect = [&](const std::string& friction, const std::string& slip_speed, bool told) {
        const std::string found = notes({"wall.floor.friction=" + friction, "wall.floor.slip_speed=" + slip_speed});
        EXPECT_EQ(found.find("wall 'floor' and 'rod': " + friction + " friction is too steep") != std::string::npos,
                  told)
            << friction << ", " << slip_speed << ": " << found;
    };
    expect("published", "1e-9", true);
    expect("published", "0.1", false);
    expect("regularised", "1e-9", false);
    expect("memory", "1e-9", false);
}

} // namespace
} // namespace skein
