#include "loads/gravity.hpp"
#include "loads/magnetic_field.hpp"

#include "scene_fixture.hpp"

#include <gtest/gtest.h>

namespace skein {
namespace {

TEST(Override, ReplacesAndAddsKeys) {
    const SceneSpec scene = read_scene(
        good_scene, {"time.duration=10", "time.dt = 1e-3", "rods.cilia.shape.elements=50", "rods.1.section.taper=0.25",
                     "load.magnetic_field.period=-3", "load.1.acceleration=[0, 0, -1]", "damping.legacy.rate=0.75",
                     "output.tips=0.1", "rods.0.placement.counts.1=6"});
    EXPECT_EQ(scene.time.duration, 10.0);
    EXPECT_EQ(scene.time.dt, 1e-3);
    EXPECT_EQ(scene.rods[0].shape.elements, 50);
    EXPECT_EQ(scene.rods[1].section.taper, 0.25);
    EXPECT_EQ(scene.loads[0].load.as<MagneticField>().period, -3.0);
    EXPECT_EQ(scene.loads[1].load.as<Gravity>().acceleration.z, -1.0);
    EXPECT_EQ(scene.damping[0].damping.rate, 0.75);
    EXPECT_EQ(scene.output.tips, 0.1);
    EXPECT_EQ(scene.rods[0].placement.counts, (std::vector<long>{8, 6}));
}

TEST(Override, TakesTextWithAndWithoutQuotes) {
    EXPECT_EQ(read_scene(good_scene, {"rods.cilia.start=pinned"}).rods[0].start, EndKind::pinned);
    EXPECT_EQ(read_scene(good_scene, {"rods.cilia.start=\"pinned\""}).rods[0].start, EndKind::pinned);
    EXPECT_EQ(read_scene(good_scene, {"title=a row = a carpet"}).title, "a row = a carpet");
    EXPECT_EQ(read_scene(good_scene, {"time.dt=auto"}).time.dt, 0.0);
}

TEST(Override, LaterOnesWin) {
    EXPECT_EQ(read_scene(good_scene, {"time.duration=10", "time.duration=20"}).time.duration, 20.0);
}

TEST(Override, MakesATableThatTheSceneLeavesOut) {
    const SceneSpec scene =
        read_scene(good_scene, {"rods.wires.magnetisation.pattern=uniform", "rods.wires.magnetisation.strength=5"});
    EXPECT_EQ(scene.rods[1].magnetisation.pattern, MagnetisationPattern::uniform);
    EXPECT_EQ(scene.rods[1].magnetisation.strength, 5.0);
}

struct Mistake {
    std::string override, message;
};

class MistakenOverride : public testing::TestWithParam<Mistake> {};

TEST_P(MistakenOverride, NamesItsOwnText) {
    EXPECT_EQ(refusal(good_scene, {GetParam().override}), "--set " + GetParam().override + ": " + GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Overrides, MistakenOverride,
    testing::Values(
        Mistake{"time.duratoin=3", "unknown key 'duratoin' in [time]; did you mean 'duration'?"},
        Mistake{"tiem.duration=3", "unknown table 'tiem' in the scene; did you mean 'time'?"},
        Mistake{"time.duration=long", "'duration' in [time]: expected a number [s], found the string \"long\""},
        Mistake{"time.duration=-1", "'duration' in [time] is -1; it must be above 0 [s]"},
        Mistake{"time.safety=nan", "'safety' in [time] is not a number; it must be a finite number"},
        Mistake{"time=3", "a path names a key, not a whole table"},
        Mistake{"title.x=3", "'title' is no table: it has no 'x'"},
        Mistake{"rods.cilia.shape=3", "'shape' in [[rods]]: expected a table [rods.shape], found the integer 3"},
        Mistake{"rods.cila.start=free", "there is no 'rods.cila'; did you mean 'cilia'?"},
        Mistake{"rods.2.start=free", "there is no 'rods.2': 'rods' has 2, counted from 0"},
        Mistake{"rods.cilia.start=glued",
                "'start' in [[rods]] knows no \"glued\"; it is one of free, pinned, clamped, clamped_frozen"},
        Mistake{"rods.cilia.section.radius_2=1",
                "'radius_2' has no use in a circular section; kind = \"elliptic\" has two radii"},
        Mistake{"load.end_force.ramp=3",
                "there is no 'load.end_force'; there are magnetic_field, gravity, muscle_wave"},
        Mistake{"load.0.rods=[\"wire\"]", "there is no group of rods 'wire'; did you mean 'wires'?"},
        Mistake{"time.duration", "expected path=value, e.g. time.duration=10"},
        Mistake{"time..duration=1", "a name is missing in the path; expected path=value, e.g. time.duration=10"}));

TEST(Override, RefusesAnAmbiguousName) {
    EXPECT_EQ(refusal(good_scene, {"damping.1.kind=legacy", "damping.legacy.rate=1"}),
              "--set damping.legacy.rate=1: 'damping.legacy' is not the only one of this name; use its number, counted "
              "from 0");
}

} // namespace
} // namespace skein
