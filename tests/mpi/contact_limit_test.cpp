// Limits that contacts leave the step of a run, under laws of pairs of groups.
#include "contact/contact_limits.hpp"
#include "coupling/interaction.hpp"
#include "partition/partition.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "simulation/world.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

namespace skein {
namespace {

/// Limit of the step, s, that the contacts of a scene leave after a short step.
double limit_by_contacts(const SceneSpec& scene) {
    const Communicator comm = Communicator::world();
    const Threads threads(1);
    auto groups = make_groups(scene);
    read_rods(comm, groups);
    Plan plan = make_plan(scene, groups, {comm.size(), 1, 1, 1, {}, Mapping::automatic});
    World world(comm, threads, std::move(groups), std::move(plan), Protocol::synchronous, Balance::never);
    world.advance(1);
    return comm.min(step_limit(world.interactions()));
}

/// Rods that overlap by a tenth of their diameter, and the law of both together, in place of that of each with its
/// like.
SceneSpec pressed_rods(const ContactLaw& alike, const ContactLaw& together) {
    SceneSpec scene;
    for (const double along_x : {1.0, 0.0}) {
        RodSpec rod = test::simple_rod();
        rod.name = along_x > 0 ? "below" : "above";
        rod.placement = {.origin = {-0.5 * along_x, 0.5 * (along_x - 1), 0.036 * (1 - along_x)},
                         .tangent = {along_x, 1 - along_x, 0}};
        scene.rods.push_back(rod);
    }
    scene.contact = ContactSpec{.law = alike};
    scene.contact_pairs = {{.between = {"below", "above"}, .law = together}};
    scene.time = {.duration = 1, .dt = 1e-7};
    return scene;
}

TEST(ContactLimit, CountsFrictionOfPairsOfGroups) {
    ContactLaw alike{.normal = ContactNormal::hertz,
                     .stiffness = 1e6,
                     .friction = ContactFriction::memory,
                     .static_friction = 0.5,
                     .kinetic_friction = 0.4};
    ContactLaw together = alike;
    together.tangential_share = 4;
    const double plain = limit_by_contacts(pressed_rods(alike, alike)),
                 pair = limit_by_contacts(pressed_rods(alike, together)),
                 both = limit_by_contacts(pressed_rods(together, together));
    EXPECT_LT(both, 0.7 * plain);
    EXPECT_EQ(pair, both);
}

/// Beside a heavy rod of another group, under a law that does not follow from masses.
TEST(ContactLimit, OfRodsWithMassesOfTheirOwnCountsLawsOfPairs) {
    const std::string file =
        testing::TempDir() + "skein_two_sizes_" + std::to_string(Communicator::world().rank()) + ".csv";
    std::ofstream(file) << "x,y,z,length,radius\n-0.5,0,0,1,0.02\n-0.5,2,0,1,0.03\n";
    const ContactLaw bounces{.normal = ContactNormal::linear, .restitution = 0.9, .collision_time = 0.01};
    ContactLaw stiff{.normal = ContactNormal::linear, .stiffness = 1e6};
    SceneSpec scene = pressed_rods(bounces, stiff);
    scene.rods[0].placement.kind = PlacementKind::file;
    scene.rods[0].placement.file = file;
    scene.rods[0].placement.origin = {0, 0, 0};
    scene.rods[1].material.density *= 1e6;
    auto groups = make_groups(scene);
    read_rods(Communicator::world(), groups);
    ASSERT_TRUE(groups[0].heterogeneous());
    EXPECT_NEAR(limit_by_contacts(scene), contact_limit(contact_mobility(groups[0]), stiff, stiff.stiffness, 0, 1),
                1e-12);
}

} // namespace
} // namespace skein
