// Scenes come back from what a checkpoint keeps of them, and from the TOML that is written of them, with every bit of
// every key.
#include "loads/gravity.hpp"
#include "plan/plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_rebuild.hpp"
#include "scene_fixture.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>

namespace skein {
namespace {

namespace fs = std::filesystem;

SceneSpec read_text(const std::string& text) {
    const std::string file = testing::TempDir() + "rebuilt.toml";
    std::ofstream(file) << text;
    SceneSpec scene = read_scene(file);
    fs::remove(file);
    return scene;
}

TEST(SceneRebuild, FromWhatCheckpointsKeep) {
    for (const std::string& file : all_scenes()) {
        SceneSpec scene = read_scene(file);
        const double dt = scene.time.dt > 0 ? scene.time.dt : 1.0 / 3e3;
        const SceneSpec back = rebuilt_scene(physics_json(scene, {}, dt), settings_json(scene), "checkpoint");
        EXPECT_EQ(back.file, file);
        scene.time.dt = dt;                                                     // which a checkpoint has in numbers
        if (scene.fluid && scene.rods.empty()) scene.fluid->expected_speed = 0; // of plans alone
        EXPECT_EQ(scene_json(back, false), scene_json(scene, false)) << file;
    }
}

TEST(SceneRebuild, OfChosenRotaryInertia) {
    const SceneSpec scene = parse_scene("thin.toml", R"(
time.duration = 1.0
[[rods]]
name = "thin"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 1e6, rotary_inertia_for_dt = "auto"}
section.radius = 0.001
shape = {length = 1.0, elements = 20}
)");
    EXPECT_EQ(scene_json(read_text(scene_toml(scene, Keys::given)), false), scene_json(scene, false));
    EXPECT_NE(scene_toml(scene, Keys::given).find("rotary_inertia_for_dt = \"auto\""), std::string::npos);
    const std::vector<RodGroup> groups = make_groups(scene);
    const SceneSpec numbers = resolved(scene, groups);
    const double dt = numbers.rods[0].material.rotary_inertia_for_dt;
    EXPECT_GT(dt, 0);
    EXPECT_EQ(groups[0].spec().material.rotary_inertia_for_dt, dt);
    // A checkpoint keeps the number, and the scene that is built of it has the same inertia.
    const std::string physics = physics_json(numbers, {}, 1e-3);
    EXPECT_EQ(physics.find("auto\""), std::string::npos);
    const SceneSpec back = rebuilt_scene(physics, settings_json(scene), "checkpoint");
    EXPECT_EQ(back.rods[0].material.rotary_inertia_for_dt, dt);
    EXPECT_EQ(make_groups(back)[0].rotary_inertia_scale, groups[0].rotary_inertia_scale);
}

TEST(SceneRebuild, OfAutomaticStiffnesses) {
    SceneSpec scene = read_scene(good_scene);
    const ContactLaw law{.stiffness = ContactLaw::automatic, .accepted_overlap = 0.03};
    scene.contact = ContactSpec{.law = law};
    scene.contact_pairs = {{.between = {scene.rods[0].name, scene.rods[0].name}, .law = law}};
    scene.walls = {{.name = "floor", .law = law}};
    EXPECT_EQ(scene_json(read_text(scene_toml(scene, Keys::given)), false), scene_json(scene, false))
        << scene_toml(scene, Keys::given);
    // A checkpoint keeps the number that it was run with.
    scene.loads = {{.load = Gravity{}}};
    const SceneSpec numbers = resolved(scene, make_groups(scene));
    for (const ContactLaw& known : {numbers.contact->law, numbers.contact_pairs[0].law, numbers.walls[0].law})
        EXPECT_GT(known.stiffness, 0);
    const std::string physics = physics_json(numbers, {}, 1e-3);
    EXPECT_EQ(physics.find("auto\""), std::string::npos);
    EXPECT_EQ(physics.find("accepted"), std::string::npos);
    const SceneSpec back = rebuilt_scene(physics, settings_json(scene), "checkpoint");
    EXPECT_EQ(back.contact->law.stiffness, numbers.contact->law.stiffness);
    EXPECT_EQ(physics_json(back, {}, 1e-3), physics);
}

TEST(SceneRebuild, TomlKeepsEveryBitOfANumber) {
    SceneSpec scene = read_scene(good_scene);
    scene.output = {};
    scene.time.dt = 0;
    for (const double x : {0.1, 1.0 / 3.0, 1e-5, 4.9e-7, 1e22, 6.02214076e23, 0.30000000000000004, 7.0}) {
        scene.time.duration = x;
        EXPECT_EQ(read_text(scene_toml(scene, Keys::given)).time.duration, x);
    }
}

TEST(SceneRebuild, WithOverrides) {
    const SceneSpec scene = read_scene(good_scene);
    const std::string physics = physics_json(scene, {}, 0.01), settings = settings_json(scene);
    const SceneSpec branch = branched_scene(physics, settings, "checkpoint", "../first@7",
                                            {"time.dt=0.005", "load.gravity.acceleration=[0,0,-1]", "start.time=zero"});
    EXPECT_EQ(branch.time.dt, 0.005);
    EXPECT_EQ(branch.start.from, "../first@7");
    EXPECT_EQ(branch.start.time, StartTime::zero);
    const auto changes = key_changes(physics, physics_json(branch, {}, 0.005));
    std::vector<std::string> keys;
    for (const KeyChange& c : changes) keys.push_back(c.key);
    EXPECT_EQ(keys, (std::vector<std::string>{"load.1.acceleration.2", "start.from", "start.time", "time.dt"}));
    EXPECT_TRUE(forbidden_changes(physics, physics_json(branch, {}, 0.005)).empty());
    // A branch of a branch begins with the state of the first one, and with time as it goes.
    EXPECT_EQ(branched_scene(physics_json(branch, {}, 0.005), settings_json(branch), "checkpoint", "../second@9", {})
                  .start.time,
              StartTime::goes_on);
    EXPECT_THROW(branched_scene(physics, settings, "checkpoint", "first", {"time.dtt=1"}), InputError);
    EXPECT_THROW(rebuilt_scene("{", settings, "checkpoint"), InputError);
}

/// Each key of a group of rods, but those that a branch may change by name, and how ends and nodes are held, which are
/// caught where they are: a new key is refused from the day it is born.
TEST(SceneRebuild, StatesBelongToTheirRods) {
    const std::string physics = physics_json(read_scene(good_scene), {}, 0.01);
    const auto json = nlohmann::json::parse(physics).flatten();
    int refused = 0, allowed = 0;
    for (const auto& item : json.items()) {
        if (!item.key().starts_with("/rods/0/")) continue;
        auto changed = json;
        changed[item.key()] = "changed";
        const auto forbidden = forbidden_changes(physics, changed.unflatten().dump());
        const auto is_of = [&](const char* what) { return item.key().starts_with(std::string("/rods/0/") + what); };
        const bool may = is_of("magnetisation/") || item.key() == "/rods/0/placement/file" || is_of("start") ||
                         is_of("end") || is_of("hold") ||
                         (item.key().starts_with("/rods/0/material/") && item.key() != "/rods/0/material/law");
        EXPECT_EQ(forbidden.empty(), may) << item.key();
        (may ? allowed : refused)++;
    }
    EXPECT_GT(refused, 20);
    EXPECT_GT(allowed, 5);
}

TEST(SceneRebuild, NamesCheckpoints) {
    EXPECT_EQ(checkpoint_name("out/first").directory, "out/first");
    EXPECT_FALSE(checkpoint_name("out/first").step);
    EXPECT_EQ(checkpoint_name("out/a@b@12").directory, "out/a@b");
    EXPECT_EQ(checkpoint_name("out/a@b@12").step, 12);
    for (const char* bad : {"out@", "@12", "out@x", "out@-1", "out@1.5", "out@99999999999999999999"})
        EXPECT_THROW(checkpoint_name(bad), InputError) << bad;
}

} // namespace
} // namespace skein
