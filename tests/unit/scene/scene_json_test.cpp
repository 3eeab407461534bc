#include "scene_fixture.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace skein {
namespace {

nlohmann::json parsed(const SceneSpec& scene, bool physics_only) {
    return nlohmann::json::parse(scene_json(scene, physics_only));
}

TEST(SceneJson, SpellsOutDefaults) {
    const auto json = parsed(read_scene(good_scene), false);
    EXPECT_EQ(json["title"], "two groups, three loads");
    EXPECT_EQ(json["time"]["safety"], 0.9);
    EXPECT_EQ(json["rods"][0]["start"], "clamped");
    EXPECT_EQ(json["rods"][0]["material"]["shear_factor"], 27.0 / 28.0);
    EXPECT_TRUE(json["rods"][0]["shape"]["start_curvature"].is_null());
    EXPECT_EQ(json["rods"][1]["shape"]["start_curvature"], (std::vector<double>{0, 0, 0}));
    EXPECT_EQ(json["rods"][1]["placement"]["origins"][1], (std::vector<double>{0, 0, 1.5}));
    EXPECT_EQ(json["load"][1]["kind"], "gravity");
    EXPECT_EQ(json["damping"][1]["rods"], (std::vector<std::string>{"wires"}));
    EXPECT_EQ(json["output"]["directors"], false);
}

TEST(SceneJson, PhysicsLeavesTitleAndOutputOut) {
    const std::string physics = scene_json(read_scene(good_scene), true);
    EXPECT_EQ(physics, scene_json(read_scene(good_scene, {"title=other", "output.tips=1"}), true));
    EXPECT_NE(physics, scene_json(read_scene(good_scene, {"load.gravity.acceleration=[0, 0, -9.82]"}), true));
    EXPECT_FALSE(nlohmann::json::parse(physics).contains("output"));
}

TEST(SceneJson, IsTheSameForTheSameScene) {
    EXPECT_EQ(scene_json(read_scene(good_scene), false),
              scene_json(read_scene(good_scene, {"time.dt=0", "rods.0.end=free"}), false));
}

TEST(SceneJson, SortsItsKeys) {
    const std::string text = scene_json(read_scene(good_scene), false);
    std::size_t last = 0;
    for (const char* key :
         {"\n  \"damping\"", "\n  \"load\"", "\n  \"output\"", "\n  \"rods\"", "\n  \"time\"", "\n  \"title\""}) {
        const std::size_t at = text.find(key);
        ASSERT_NE(at, std::string::npos) << key;
        EXPECT_GT(at, last);
        last = at;
    }
}

TEST(SceneJson, KeepsEveryBitOfANumber) {
    SceneSpec scene = read_scene(good_scene);
    for (const double x : {0.1, 1.0 / 3.0, 5e-324, 1.7976931348623157e308, 6.02214076e23, 0.30000000000000004}) {
        scene.time.duration = x;
        EXPECT_EQ(parsed(scene, true)["time"]["duration"].get<double>(), x);
    }
}

} // namespace
} // namespace skein
