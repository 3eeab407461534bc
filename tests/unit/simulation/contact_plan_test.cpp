// Overlaps that a plan expects, and the stiffness that it finds for them.
#include "loads/gravity.hpp"
#include "physics/contact/contact_plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"
#include "support/scenes_for_tests.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace skein {
namespace {

/// Largest overlaps that were measured in the nest of 1536 rods, pressed from the same settled state.
struct PressedNest {
    double stiffness, pressure, overlap; ///< N/m^1.5, Pa, over the diameter
};

TEST(Plan, ExpectsTheOverlapsThatWereSeenInTheNest) {
    SceneSpec scene = read_scene(std::string(SKEIN_SOURCE_DIR) + "/apps/nest/nest_1536.toml");
    const auto groups = make_groups(scene);
    for (const PressedNest& seen : {PressedNest{3.1623e6, 2000, 0.107},
                                    {3.1623e6, 4000, 0.139},
                                    {3.1623e6, 7900, 0.198},
                                    {1.2649e7, 2000, 0.051},
                                    {1.2649e7, 6000, 0.083},
                                    {1.2649e7, 7900, 0.093}}) {
        scene.contact->law.stiffness = seen.stiffness;
        for (Wall& wall : scene.walls)
            if (wall.servo.drives()) wall.servo.turn_back_above = seen.pressure;
        const Plan plan = make_plan(scene, groups, {});
        EXPECT_EQ(plan.find<TouchPlan>()->estimate.by, "pressure");
        EXPECT_GT(plan.find<TouchPlan>()->estimate.overlap, 0.6 * seen.overlap)
            << seen.stiffness << " at " << seen.pressure;
        EXPECT_LT(plan.find<TouchPlan>()->estimate.overlap, 1.25 * seen.overlap)
            << seen.stiffness << " at " << seen.pressure;
    }
}

/// Two crossed rods over a floor.
SceneSpec crossed_rods() {
    SceneSpec scene;
    scene.time = {.duration = 1};
    for (const double along_x : {1.0, 0.0}) {
        RodSpec rod = test::simple_rod();
        rod.name = along_x > 0 ? "below" : "above";
        rod.placement = {.origin = {-0.5 * along_x, 0.5 * (along_x - 1), 0.04 * (1 - along_x)},
                         .tangent = {along_x, 1 - along_x, 0}};
        scene.rods.push_back(rod);
    }
    scene.contact = ContactSpec{.law = {.stiffness = ContactLaw::automatic}};
    return scene;
}

TEST(Plan, AutomaticStiffnessGivesTheAcceptedOverlapUnderTheForceExpected) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (const double accepted : {0.01, 0.05, 0.1}) {
            SceneSpec scene = crossed_rods();
            scene.loads = {{.load = Gravity{}}};
            scene.contact->law.normal = normal;
            scene.contact->law.accepted_overlap = accepted;
            scene.walls = {{.name = "floor", .law = scene.contact->law}};
            const auto groups = make_groups(scene);
            const Plan plan = make_plan(scene, groups, {});
            EXPECT_EQ(plan.find<TouchPlan>()->estimate.by, "weight");
            EXPECT_NEAR(plan.find<TouchPlan>()->estimate.overlap, accepted, 1e-12);
            EXPECT_NEAR(plan.find<TouchPlan>()->estimate.wall_overlaps.at(0), accepted, 1e-12);
            EXPECT_NE(to_text(plan).find("(auto)"), std::string::npos) << to_text(plan);
            EXPECT_NE(to_json(plan).find("\"expected_overlap\""), std::string::npos);
            // Weight, gravity and stiffness go together.
            scene.loads[0].load.as<Gravity>().acceleration = {0, 0, -98.1};
            EXPECT_NEAR(make_plan(scene, groups, {}).find<ContactPlan>()->spec.law.stiffness /
                            plan.find<ContactPlan>()->spec.law.stiffness,
                        10, 1e-9);
            // What is given as a number stays, and is told of alike.
            scene.contact->law.stiffness = 2 * plan.find<ContactPlan>()->spec.law.stiffness;
            EXPECT_EQ(make_plan(scene, groups, {}).find<ContactPlan>()->spec.law.stiffness,
                      2 * plan.find<ContactPlan>()->spec.law.stiffness);
        }
}

TEST(Plan, NamesAStiffnessOnlyWhereOneHoldsForAllContacts) {
    SceneSpec scene = crossed_rods();
    scene.loads = {{.load = Gravity{}}};
    scene.contact->law.normal = ContactNormal::linear;
    const auto groups = make_groups(scene);
    const double firm = make_plan(scene, groups, {}).find<ContactPlan>()->spec.law.stiffness,
                 needed = 0.5 * firm; // accepted: half of what is allowed
    scene.contact->law.stiffness = 0.01 * firm;
    const std::string alone = to_text(make_plan(scene, groups, {}));
    EXPECT_NE(alone.find(fmt::format("which stiffness = {:.2g} would hold", needed)), std::string::npos) << alone;
    scene.contact_pairs = {{.between = {"below", "above"}, .law = scene.contact->law}};
    scene.contact->law.stiffness = firm;
    const std::string pair = to_text(make_plan(scene, groups, {}));
    EXPECT_NE(pair.find("which 50 times the stiffness would hold"), std::string::npos) << pair;
}

TEST(Plan, AutomaticStiffnessIsThatOfTheMaterialWhereNothingPresses) {
    SceneSpec scene = crossed_rods();
    const double own = 8.0 / 9 * 1e6 * std::sqrt(0.02); // Hertz, crossed cylinders, E* = E/1.5
    EXPECT_NEAR(make_plan(scene, make_groups(scene), {}).find<ContactPlan>()->spec.law.stiffness / own, 1, 1e-12);
    // Ends that are moved may press by more than rods weigh.
    scene.loads = {{.load = Gravity{.acceleration = {0, 0, -1e-6}}}};
    EXPECT_LT(make_plan(scene, make_groups(scene), {}).find<ContactPlan>()->spec.law.stiffness, 1e-3 * own);
    scene.rods[1].end = EndKind::clamped;
    scene.rods[1].end_motion = {.amplitude = {0, 0, 0.01}, .period = 1};
    EXPECT_NEAR(make_plan(scene, make_groups(scene), {}).find<ContactPlan>()->spec.law.stiffness / own, 1, 1e-12);
}

TEST(Plan, AutomaticStiffnessOfBodiesThatNothingPressesIsRefused) {
    SceneSpec scene = crossed_rods();
    scene.file = "balls.toml";
    scene.rods = {test::rigid_body(0.001, 0.02)};
    scene.rods[0].placement = {.kind = PlacementKind::line, .counts = {3}, .spacing = {0.05}};
    try {
        make_plan(scene, make_groups(scene), {});
        FAIL() << "accepted";
    } catch (const InputError& e) {
        for (const char* part : {"balls.toml", "[contact]", "auto", "give a number"})
            EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
}

} // namespace
} // namespace skein
