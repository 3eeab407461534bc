#include "loads/gravity.hpp"
#include "loads/magnetic_field.hpp"
#include "loads/muscle_wave.hpp"

#include "scene_fixture.hpp"

#include <gtest/gtest.h>

#include <fstream>

namespace skein {
namespace {

void expect_equal(const Vec3d& a, const Vec3d& b) {
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.y, b.y);
    EXPECT_EQ(a.z, b.z);
}

class GoodScene : public testing::Test {
protected:
    const SceneSpec scene = read_scene(good_scene);
};

TEST_F(GoodScene, TimeTakesIntegersAndTheWordAuto) {
    EXPECT_EQ(scene.title, "two groups, three loads");
    EXPECT_EQ(scene.file, good_scene);
    EXPECT_EQ(scene.time.duration, 216.0);
    EXPECT_EQ(scene.time.dt, 0.0);
    EXPECT_EQ(scene.time.divide, 72.0);
    EXPECT_EQ(scene.time.safety, 0.9);
}

TEST_F(GoodScene, RodsFromHeaders) {
    ASSERT_EQ(scene.rods.size(), 2u);
    const RodSpec& cilia = scene.rods[0];
    EXPECT_EQ(cilia.name, "cilia");
    EXPECT_EQ(cilia.source, good_scene + ":8");
    EXPECT_EQ(cilia.start, EndKind::clamped);
    EXPECT_EQ(cilia.end, EndKind::free);
    EXPECT_EQ(cilia.material.youngs_modulus, 1.85e5);
    EXPECT_EQ(cilia.section.kind, SectionKind::circular);
    EXPECT_EQ(cilia.shape.elements, 25);
    EXPECT_FALSE(cilia.shape.start_curvature.has_value());
    EXPECT_EQ(cilia.placement.kind, PlacementKind::lattice);
    EXPECT_EQ(cilia.placement.counts, (std::vector<long>{8, 4}));
    EXPECT_EQ(cilia.placement.spacing, (std::vector<double>{1.5, 2.0}));
    expect_equal(cilia.placement.origin, {0.1, 0.2, 0.3});
    EXPECT_EQ(cilia.magnetisation.pattern, MagnetisationPattern::wave_x);
    EXPECT_EQ(cilia.magnetisation.wavelength_x, -10.5);
}

TEST_F(GoodScene, RodsFromInlineTablesAndDottedKeys) {
    const RodSpec& wires = scene.rods[1];
    EXPECT_EQ(wires.material.shear_modulus, 4e5);
    EXPECT_EQ(wires.section.radius_2, 0.02);
    EXPECT_EQ(wires.end, EndKind::pinned);
    ASSERT_EQ(wires.shape.rest_curvature_profile.size(), 2u);
    expect_equal(wires.shape.rest_curvature_profile[1], {0, 2, 0});
    ASSERT_TRUE(wires.shape.start_curvature.has_value());
    expect_equal(*wires.shape.start_curvature, {0, 0, 0});
    ASSERT_EQ(wires.placement.origins.size(), 2u);
    expect_equal(wires.placement.origins[1], {0, 0, 1.5});
}

TEST_F(GoodScene, LoadsDampingAndOutput) {
    ASSERT_EQ(scene.loads.size(), 3u);
    const auto& field = scene.loads[0].load.as<MagneticField>();
    EXPECT_EQ(field.rotating, 0.08);
    EXPECT_EQ(field.ramp.duration, 36.0);
    EXPECT_EQ(scene.loads[0].rods, (std::vector<std::string>{"cilia"}));
    EXPECT_EQ(scene.loads[0].source, good_scene + ":45");
    EXPECT_EQ(scene.loads[1].load.as<Gravity>().acceleration.z, -9.81);
    EXPECT_TRUE(scene.loads[1].rods.empty());
    EXPECT_EQ(scene.loads[2].load.as<MuscleWave>().profile, (std::vector<double>{1, 0.5}));
    ASSERT_EQ(scene.damping.size(), 2u);
    EXPECT_EQ(scene.damping[0].damping.kind, DampingKind::legacy);
    EXPECT_EQ(scene.damping[1].damping.rotational, 1e-6);
    EXPECT_EQ(scene.damping[1].rods, (std::vector<std::string>{"wires"}));
    EXPECT_EQ(scene.output.series, 0.5);
    EXPECT_EQ(scene.output.precision, Precision::double_);
    EXPECT_FALSE(scene.output.directors);
}

TEST(SceneFile, SaysWhenThereIsNone) {
    EXPECT_EQ(refusal("nowhere/scene.toml"), "nowhere/scene.toml: there is no such file");
    EXPECT_EQ(refusal(test_data), test_data + ": not a file");
}

class WrittenScene : public testing::Test {
protected:
    std::string written(const std::string& text) const {
        std::ofstream(file, std::ios::binary) << text;
        return refusal(file);
    }
    const std::string file = testing::TempDir() + "skein_written_scene.toml";
};

TEST_F(WrittenScene, LineEndsOfWindows) {
    const std::string said = written("[time]\r\nduration = 10.0\r\nlength = 3\r\n");
    EXPECT_TRUE(said.starts_with(file + ":3:1: unknown key 'length' in [time]")) << said;
    EXPECT_EQ(said.find('\r'), std::string::npos);
}

TEST_F(WrittenScene, NamesTenProblemsAndCountsTheRest) {
    std::string text = "[time]\nduration = 1.0\n";
    for (int i = 0; i < 13; ++i) text += "wrong_" + std::to_string(i) + " = 0\n";
    const std::string said = written(text);
    for (int line = 3; line < 13; ++line)
        EXPECT_NE(said.find(file + ":" + std::to_string(line) + ":1: unknown key"), std::string::npos);
    EXPECT_EQ(said.find("wrong_10"), std::string::npos);
    EXPECT_TRUE(said.ends_with("and 3 more")) << said;
}

TEST_F(WrittenScene, NothingAtAll) {
    EXPECT_TRUE(written("").starts_with(file + ":1:1: missing table [time] in the scene"));
}

} // namespace
} // namespace skein
