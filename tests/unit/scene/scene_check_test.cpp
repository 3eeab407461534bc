// Scenes made in C++. What scene files can get wrong is in malformed/.
#include "scene/scene_check.hpp"

#include "core/field_looker.hpp"
#include "loads/end_force.hpp"
#include "loads/gravity.hpp"
#include "loads/muscle_wave.hpp"
#include "scene/scene_keys.hpp"
#include "scene_fixture.hpp"

#include <gtest/gtest.h>

namespace skein {
namespace {

SceneSpec one_rod() {
    SceneSpec scene;
    scene.time.duration = 1;
    RodSpec rod;
    rod.name = "rod";
    rod.material = {.density = 1000, .youngs_modulus = 1e6};
    rod.section.radius = 0.01;
    rod.shape.length = 1;
    rod.shape.elements = 10;
    scene.rods = {rod};
    return scene;
}

TEST(CheckScene, IsContentWithARod) { EXPECT_EQ(refusal(one_rod()), ""); }

TEST(CheckScene, IsContentWithWhatReadSceneGives) { EXPECT_EQ(refusal(read_scene(good_scene)), ""); }

/// Gives every time among a load's keys, and counts them.
class SetTimes final : public FieldLooker {
public:
    using FieldLooker::visit;
    int times = 0;

    void visit(const Field& field, double& value) override {
        if (field.unit != "s") return;
        value = 1;
        ++times;
    }
};

TEST(CheckScene, RelaxesUnderNoLoadThatChangesWithTime) {
    int changing = 0;
    for (std::size_t kind = 0; kind < load_kinds().size(); ++kind) {
        SceneSpec scene = one_rod();
        scene.time.relax = true;
        Load load = make_load(static_cast<int>(kind));
        SetTimes times;
        load.fields(times);
        scene.loads.push_back({.load = load});
        const std::string text = refusal(scene);
        EXPECT_EQ(text.find("do not change with time") != std::string::npos, times.times > 0)
            << load.kind() << ": " << text;
        changing += times.times > 0;
    }
    EXPECT_GE(changing, 6);
}

TEST(CheckScene, RelaxesOnlyWhatHasARestOfItsOwn) {
    const auto refused = [](auto change) {
        SceneSpec scene = one_rod();
        scene.time.relax = true;
        change(scene);
        return refusal(scene).find("relax") != std::string::npos;
    };
    EXPECT_FALSE(refused([](SceneSpec&) {}));
    EXPECT_FALSE(refused([](SceneSpec& s) { s.loads.push_back({.load = Gravity{}}); }));
    EXPECT_TRUE(refused([](SceneSpec& s) { s.time.dt = 0.1; }));
    EXPECT_TRUE(refused([](SceneSpec& s) { s.time.integrator = Integrator::pefrl; }));
    EXPECT_TRUE(refused([](SceneSpec& s) { s.damping.push_back({.damping = {.rate = 1}}); }));
    EXPECT_TRUE(refused([](SceneSpec& s) { s.rods[0].material.rotary_inertia_scale = 10; }));
    EXPECT_TRUE(refused([](SceneSpec& s) { s.rods[0].material.law = Law::elastica; }));
    EXPECT_FALSE(refused([](SceneSpec& s) { s.rods[0].shape.closed = true; }));
    EXPECT_TRUE(refused([](SceneSpec& s) { s.rods[0].shape.velocity = {1, 0, 0}; }));
    EXPECT_TRUE(refused([](SceneSpec& s) { s.output.audit = true; }));
    SceneSpec scene = one_rod();
    scene.time.relax_tolerance = 1e-6;
    EXPECT_EQ(refusal(scene), "'relax_tolerance' has no use without relax = true");
}

TEST(CheckScene, NamesTheTableWhereTheSceneHasNoFile) {
    SceneSpec scene = one_rod();
    scene.rods[0].section.radius_2 = 0.02;
    EXPECT_EQ(refusal(scene), "rods.0: 'radius_2' has no use in a circular section; kind = \"elliptic\" has two radii");
}

TEST(CheckScene, NamesTheLineWhereItHasOne) {
    SceneSpec scene = read_scene(good_scene);
    scene.loads[0].rods = {"cilla"};
    EXPECT_EQ(refusal(scene), good_scene + ":45: there is no group of rods 'cilla'; did you mean 'cilia'?");
}

TEST(CheckScene, NamesAllThatIsWrong) {
    SceneSpec scene = one_rod();
    scene.rods.push_back(scene.rods[0]);
    scene.time.dt = 2;
    scene.loads.push_back({.load = EndForce{}});
    scene.damping.push_back({.damping = {.kind = DampingKind::physical, .rate = 1}});
    EXPECT_EQ(
        refusal(scene),
        "rods.1: two groups of rods are named 'rod'\n"
        "'dt' of 2 s is longer than 'duration' of 1 s\n"
        "load.0: an end_force needs 'start' or 'end' [N]: both are 0\n"
        "damping.0: 'rate' has no use for a damping of kind \"physical\"\n"
        "damping.0: 'translational' [kg/s] or 'rotational' [kg m^2/s] is needed for a damping of kind \"physical\"");
}

TEST(CheckScene, ChecksAMusclesProfileAgainstEachOfItsGroups) {
    SceneSpec scene = one_rod();
    scene.rods.push_back(scene.rods[0]);
    scene.rods[1].name = "long";
    scene.rods[1].shape.elements = 20;
    MuscleWave wave{};
    wave.amplitude = wave.period = wave.wavelength = 1;
    wave.profile.assign(9, 1.0);
    scene.loads.push_back({.load = wave, .rods = {"rod"}});
    EXPECT_EQ(refusal(scene), "");
    scene.loads[0].rods.clear();
    EXPECT_EQ(refusal(scene),
              "load.0: 'profile' has 9 values, but needs 19: one for each inner vertex (elements - 1) of group 'long'");
}

TEST(CheckScene, LetsARotationBeSwitchedOff) {
    EXPECT_EQ(refusal(good_scene, {"load.magnetic_field.rotating=0", "load.magnetic_field.constant=[0, 0, 0.1]"}), "");
}

TEST(ChangedKeys, AreThoseThatDifferFromTheirDefaults) {
    SceneSpec scene;
    EXPECT_TRUE(changed_keys(scene).empty());
    scene.time.safety = 0.5;
    scene.rods.emplace_back().section.taper = 0.5;
    scene.rods[0].shape.start_curvature = Vec3d{0, 0, 0};
    scene.loads.push_back({.load = Gravity{.acceleration = {1, 0, 0}}});
    EXPECT_EQ(changed_keys(scene), (std::set<std::string>{"time.safety", "rods.0.section.taper",
                                                          "rods.0.shape.start_curvature", "load.0.acceleration"}));
}

} // namespace
} // namespace skein
