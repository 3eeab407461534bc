// Scenes with other numbers of elements that are the same problem.
#include "scene/scene_refine.hpp"

#include "core/field_looker.hpp"

#include "loads/muscle_torques.hpp"
#include "loads/muscle_wave.hpp"
#include "loads/plane_friction.hpp"
#include "plan/plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/scene_stages.hpp"
#include "scene_fixture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace skein {
namespace {

const std::string rod_text = R"(
time.duration = 1.0
[[rods]]
name = "one"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 0.01
shape = {length = 1.0, elements = 4}
)";

SceneSpec scene_of(const std::string& more = "", const std::vector<std::string>& overrides = {}) {
    return parse_scene("refine.toml", rod_text + more, overrides);
}

std::string refused(const SceneSpec& scene, const Refinement& by) {
    try {
        refined(scene, by);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

/// Notes every key that takes a list of numbers or of vectors.
class Lists final : public FieldLooker {
public:
    using FieldLooker::visit;
    std::set<std::string> names;
    void visit(const Field& f, std::vector<double>&) override { names.insert(std::string(f.name)); }
    void visit(const Field& f, std::vector<long>&) override { names.insert(std::string(f.name)); }
    void visit(const Field& f, std::vector<Vec3d>&) override { names.insert(std::string(f.name)); }
};

TEST(SceneRefine, EveryListOfNumbersHasARuleOrNeedsNone) {
    // A new key that takes a list may be one per element, node or vertex: give it a rule in scene_refine.cpp, or
    // refine() of its load, or say here that it is of something else.
    const std::set<std::string> ruled = {
        "profile", "profile_2", "table", "length_profile", "rest_curvature_profile", "start_curvature_profile",
        "nodes",   "elements"};
    const std::set<std::string> of_something_else = {
        "coefficients", "shear_factors", "bending_stiffness", "counts",        "spacing",
        "origins",      "tangents",      "normals",           "elevation",     "azimuth",
        "times",        "translation",   "rotation",          "magnetisation", "profile_at"};
    Lists lists;
    RodSpec rods;
    rods.fields(lists);
    for (std::size_t kind = 0; kind < load_kinds().size(); ++kind) make_load(static_cast<int>(kind)).fields(lists);
    Damping damping;
    damping.fields(lists);
    for (const std::string& name : lists.names)
        EXPECT_TRUE(ruled.contains(name) || of_something_else.contains(name)) << "'" << name << "'";
}

TEST(SceneRefine, ShippedScenesAreTheSameProblem) {
    for (const std::string& file : all_scenes()) {
        const SceneSpec scene = read_scene(file);
        if (std::any_of(scene.rods.begin(), scene.rods.end(), [](const RodSpec& r) {
                return r.placement.kind == PlacementKind::file || r.placement.kind == PlacementKind::packing;
            }))
            continue; // of nodes as given, or long to pack
        const SceneSpec fine = refined(scene, {2, 1});
        const auto groups = make_groups(scene), finer = make_groups(fine);
        for (std::size_t g = 0; g < groups.size(); ++g) {
            if (!groups[g].strained()) continue;
            EXPECT_EQ(finer[g].elements(), 2 * groups[g].elements()) << file;
            const auto mass = [](const RodGroup& group) {
                return std::accumulate(group.node_mass.begin(), group.node_mass.end(), 0.0);
            };
            EXPECT_NEAR(mass(finer[g]) / mass(groups[g]), 1, 1e-2) << file;
        }
    }
}

TEST(SceneRefine, ProfilesAreLinearBetweenTheirPlaces) {
    // Linear along the rod, also where its elements differ in length: refined, and halved, it is the same line.
    const SceneSpec scene =
        scene_of("", {"rods.one.section.profile=[1.0625, 1.25, 1.5, 1.8125]",
                      "rods.one.shape.length_profile=[0.5, 1.0, 1.0, 1.5]",
                      "rods.one.shape.rest_curvature_profile=[[0.5, 0, 0], [1.5, 0, 0], [2.5, 0, 0]]"});
    for (const Refinement by : {Refinement{2, 1}, Refinement{4, 1}, Refinement{1, 2}}) {
        const SceneSpec other = refined(scene, by);
        const Shape& s = other.rods[0].shape;
        ASSERT_EQ(s.elements, by.of(4));
        EXPECT_NEAR(std::accumulate(s.length_profile.begin(), s.length_profile.end(), 0.0), 4, 1e-14);
        double at = 0; // from the start, in the unit of length_profile
        for (std::size_t i = 0; i < s.length_profile.size(); ++i) {
            const double middle = at + 0.5 * s.length_profile[i];
            EXPECT_NEAR(other.rods[0].section.profile[i], 1 + 0.25 * middle, 1e-14) << i;
            at += s.length_profile[i];
            if (i + 1 < s.length_profile.size()) {
                EXPECT_NEAR(s.rest_curvature_profile[i].x, at, 1e-14) << i;
            }
        }
    }
}

TEST(SceneRefine, RingsGoRound) {
    const SceneSpec ring =
        scene_of("", {"rods.one.shape.closed=true",
                      "rods.one.shape.start_curvature_profile=[[1, 0, 0], [2, 0, 0], [3, 0, 0], [2, 0, 0]]"});
    const SceneSpec fine = refined(ring, {2, 1});
    const auto& c = fine.rods[0].shape.start_curvature_profile;
    const double expected[] = {1.5, 1, 1.5, 2, 2.5, 3, 2.5, 2};
    ASSERT_EQ(c.size(), 8u);
    for (std::size_t i = 0; i < 8; ++i) EXPECT_DOUBLE_EQ(c[i].x, expected[i]) << i;
}

TEST(SceneRefine, HeldNodesStayWhereTheyAre) {
    const SceneSpec fine = refined(scene_of("hold = {nodes = [1, -1, -2], elements = [0, 2, 3]}\n"), {2, 1});
    EXPECT_EQ(fine.rods[0].hold.nodes, (std::vector<long>{2, 8, 6}));
    EXPECT_EQ(fine.rods[0].hold.elements, (std::vector<long>{0, 4, 5, 6, 7}))
        << "one at an end stays one, a stretch keeps its length";
    EXPECT_NE(refused(scene_of("hold.elements = [1]\n"), {2, 1}).find("hold.elements"), std::string::npos);
    EXPECT_NE(refused(scene_of("hold.nodes = [1]\n"), {1, 2}).find("hold.nodes"), std::string::npos);
}

TEST(SceneRefine, LoadsAlongTheRod) {
    const std::string loads = R"(
[[load]]
kind = "muscle_wave"
amplitude = 1.0
profile = [1.0, 2.0, 3.0]
period = 1.0
wavelength = 1.0
[[load]]
kind = "muscle_torques"
table = [1.0, 2.0, 3.0, 4.0]
period = 1.0
wave_number = 1.0
[[load]]
kind = "anisotropic_plane"
stiffness = 8.0
damping = 4.0
[[damping]]
kind = "physical"
translational = 8.0
rotational = 2.0
[[damping]]
kind = "laplacian"
rate = 5.0
order = 2
)";
    const SceneSpec fine = refined(scene_of(loads), {4, 1});
    const auto& wave = fine.loads[0].load.as<MuscleWave>().profile;
    ASSERT_EQ(wave.size(), 15u);
    for (std::size_t i = 0; i < wave.size(); ++i) EXPECT_NEAR(wave[i], 0.25 * static_cast<double>(i + 1), 1e-14);
    const auto& table = fine.loads[1].load.as<MuscleTorques>().table;
    ASSERT_EQ(table.size(), 16u);
    for (std::size_t i = 0; i < table.size(); ++i) EXPECT_NEAR(table[i], 0.25 * static_cast<double>(i + 1), 1e-14);
    EXPECT_EQ(fine.loads[2].load.as<PlaneFriction>().stiffness, 2);
    EXPECT_EQ(fine.loads[2].load.as<PlaneFriction>().damping, 1);
    EXPECT_EQ(fine.damping[0].damping.translational, 2);
    EXPECT_EQ(fine.damping[0].damping.rotational, 0.5);
    EXPECT_EQ(fine.damping[1].damping.rate, 5);
}

TEST(SceneRefine, ScaledInertiaStaysThatOfTheScene) {
    const SceneSpec scene = scene_of("", {"rods.one.material.rotary_inertia_for_dt=2e-3"}),
                    fine = refined(scene, {4, 1});
    const auto scales = [](const SceneSpec& s) { return make_groups(s)[0].rotary_inertia_scale; };
    ASSERT_FALSE(scales(scene).empty());
    EXPECT_GT(scales(scene)[2], 1);
    EXPECT_EQ(scales(fine), std::vector<double>(16, scales(scene)[2]));
    const SceneSpec tapered =
        scene_of("", {"rods.one.material.rotary_inertia_for_dt=2e-3", "rods.one.section.taper=0.5"});
    EXPECT_NE(refused(tapered, {2, 1}).find("rotary_inertia_for_dt"), std::string::npos);
}

TEST(SceneRefine, RotaryInertiaThatIsChosenFallsWithTheElements) {
    const SceneSpec scene =
        scene_of("", {"rods.one.start=clamped", "rods.one.shape.elements=20", "rods.one.section.radius=1e-3",
                      "rods.one.material.rotary_inertia_for_dt=auto"});
    const auto scale = [](const SceneSpec& s) { return make_groups(s)[0].rotary_inertia_scale.at(5); };
    EXPECT_NEAR(scale(scene) / scale(refined(scene, {2, 1})), 4, 0.1);
    EXPECT_NEAR(scale(scene) / scale(refined(scene, {1, 2})), 0.25, 0.02);
    ASSERT_EQ(refinement_notes(scene).size(), 1u);
    EXPECT_NE(refinement_notes(scene)[0].find("is chosen for each number of elements"), std::string::npos);
}

TEST(SceneRefine, WhatCannotBeRefinedIsNamed) {
    EXPECT_NE(refused(scene_of("", {"rods.one.shape.elements=5"}), {1, 2}).find("shape.elements"), std::string::npos);
    EXPECT_NE(refused(scene_of("", {"start.from=elsewhere"}), {2, 1}).find("start.from"), std::string::npos);
    const SceneSpec bodies = scene_of("[[bodies]]\nname = \"ball\"\ndensity = 1000.0\nspheres = {radii = [0.1]}\n"
                                      "[[damping]]\nkind = \"physical\"\ntranslational = 1.0\n");
    EXPECT_NE(refused(bodies, {2, 1}).find("damping.rods"), std::string::npos);
    const SceneSpec traced = read_scene(std::string(SHIPPED_SCENES) + "/traced/traced.toml");
    EXPECT_NE(refused(traced, {2, 1}).find("placement.file"), std::string::npos);
}

const std::string stages_text = R"(
[[damping]]
kind = "physical"
translational = 1e-3
[[stage]]
name = "a"
duration = 0.5
[[stage]]
name = "b"
)";
const std::vector<double> first_stage{0.0}, second_stage{0.0, 0.5};

TEST(SceneRefine, WhatStagesChangeGoesAlong) {
    const SceneSpec scene = scene_of(stages_text + R"(change = ["damping.physical.translational=4e-3",
        "rods.one.hold.nodes=[2]", "rods.one.material.youngs_modulus=2e6"])"),
                    fine = refined(scene, {2, 1}), later = stage_scene(fine, second_stage);
    EXPECT_EQ(later.damping[0].damping.translational, 2e-3);
    EXPECT_EQ(later.rods[0].hold.nodes, std::vector<long>{4});
    EXPECT_EQ(later.rods[0].material.youngs_modulus, 2e6);
    EXPECT_EQ(stage_scene(fine, first_stage).damping[0].damping.translational, 0.5e-3);
    const SceneSpec stiffer = scene_of(stages_text + "change = [\"rods.one.material.youngs_modulus=2e6\"]");
    EXPECT_EQ(refined(stiffer, {2, 1}).stages[1].change, stiffer.stages[1].change);
}

TEST(SceneRefine, InertiaThatAStageScalesStaysThatOfItsElements) {
    const SceneSpec scene = scene_of(stages_text + "change = [\"rods.one.material.rotary_inertia_for_dt=2e-3\"]"),
                    fine = refined(scene, {4, 1});
    const auto scales = [](const SceneSpec& s) { return make_groups(s, second_stage)[0].rotary_inertia_scale; };
    EXPECT_GT(scales(scene)[2], 1);
    EXPECT_EQ(scales(fine), std::vector<double>(16, scales(scene)[2]));
}

TEST(SceneRefine, WhatAStageChangesAndCannotBeRefinedIsNamed) {
    const SceneSpec odd = scene_of(stages_text + "change = [\"rods.one.hold.nodes=[1]\"]");
    const std::string text = refused(odd, {1, 2});
    EXPECT_NE(text.find("stage 'b'"), std::string::npos) << text;
    EXPECT_NE(text.find("hold.nodes: node 1 of 'one' falls between two nodes"), std::string::npos) << text;
}

TEST(SceneRefine, BodiesKeepTheirDamping) {
    const SceneSpec bodies = scene_of("[[bodies]]\nname = \"ball\"\ndensity = 1000.0\nspheres = {radii = [0.1]}\n"
                                      "[[damping]]\nkind = \"physical\"\ntranslational = 1.0\nrods = [\"ball\"]\n");
    EXPECT_EQ(refined(bodies, {2, 1}).damping[0].damping.translational, 1);
}

} // namespace
} // namespace skein
