// Packed rods of a whole scene: groups keep clear of each other, and lie in tiles as they were placed.
#include "loads/magnetic_field.hpp"
#include "placement/packing.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "skein/core/index.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

namespace skein {
namespace {

/// Two groups packed into one box, around a row of rods that stand in it.
SceneSpec nest() {
    SceneSpec scene;
    scene.time = {.duration = 1e-3};
    RodSpec row = test::simple_rod(7);
    row.name = "row";
    row.placement = {.kind = PlacementKind::line, .origin = {0.5, 1, 0.5}, .counts = {3}, .spacing = {0.5}};
    RodSpec sticks = test::simple_rod(9);
    sticks.name = "sticks";
    sticks.placement.kind = PlacementKind::packing;
    sticks.placement.packing = {.count = 37, .upper = {2, 2, 2}};
    RodSpec thin = test::simple_rod(5);
    thin.name = "thin";
    thin.section.radius = 0.01;
    thin.placement = sticks.placement;
    thin.placement.packing.seed = 2;
    thin.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 1000, .direction = {1, 0, 0}};
    scene.rods = {row, sticks, thin};
    scene.loads = {{.load = MagneticField{.constant = {0, 0, 1e-3}}}};
    return scene;
}

TEST(PackedScene, GroupsKeepClearOfEachOther) {
    const auto groups = make_groups(nest());
    std::vector<Capsule> all;
    std::vector<std::int64_t> rod;
    for (const RodGroup& group : groups)
        for (std::int64_t i = 0; i < group.count(); ++i) {
            group.append_capsules(i, all);
            rod.resize(all.size(), group.first_gid() + i);
        }
    EXPECT_EQ(rod.back(), 3 + 37 + 37 - 1);
    for (std::size_t a = 0; a < all.size(); ++a)
        for (std::size_t b = 0; b < a; ++b)
            if (rod[a] != rod[b]) {
                ASSERT_FALSE(closer(all[a], all[b], all[a].radius + all[b].radius)) << rod[a] << " and " << rod[b];
            }
}

TEST(PackedScene, TilesHoldTheStartStates) {
    for (const Mapping mapping : {Mapping::across, Mapping::along})
        for (const int lanes : {1, 8}) {
            const test::Stage stage(nest(), lanes, 1, mapping);
            for (std::size_t i = 0; i < stage.rods->local().size(); ++i) {
                const LocalRod& rod = stage.rods->local()[i];
                const RodGroup& group = nth(stage.groups, rod.group);
                std::vector<Slot<1>> placed(static_cast<std::size_t>(group.slots())), held(placed.size());
                group.start_state(rod.index, placed);
                stage.rods->export_rod(i, held);
                EXPECT_EQ(hash_rod(rod.gid, held), hash_rod(rod.gid, placed)) << rod.gid;
            }
        }
}

TEST(PackedScene, StepsAlikeForAnyWidthAndThreads) {
    const auto digest = [](int lanes, int threads, Mapping mapping) {
        test::Stage stage(nest(), lanes, threads, mapping);
        stage.advance(50);
        return stage.rods->digest();
    };
    const auto expected = digest(1, 1, Mapping::across);
    for (const Mapping mapping : {Mapping::across, Mapping::along})
        for (const int lanes : test::built_lanes({2, 4, 8})) EXPECT_EQ(digest(lanes, 2, mapping), expected);
}

/// A magnet that is not yet turned feels m x B of its direction in the lab, whatever the frame of its rod.
TEST(PackedScene, MagnetisationKeepsItsDirectionInTheLab) {
    test::Stage stage(nest());
    stage.advance(1);
    const RodGroup& group = stage.groups[2];
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    for (std::size_t i = 0; i < stage.rods->local().size(); ++i) {
        if (stage.rods->local()[i].group != 2) continue;
        stage.rods->export_rod(i, state);
        for (std::size_t k = 0; k + 1 < state.size(); ++k) {
            const ElementConstants& c = group.element[k];
            const Vec3d couple = (1000 * c.volume * stage.clock.dt()) *
                                 (group.start_director(stage.rods->local()[i].index, k) * Vec3d{0, -1e-3, 0});
            EXPECT_LT(norm(scale(c.inertia, lane(state[k].spin, 0)) - couple),
                      1e-6 * 1000 * c.volume * stage.clock.dt() * 1e-3);
        }
    }
}

TEST(PackedScene, PlanTellsHowFullItIs) {
    const SceneSpec scene = nest();
    const Plan plan = make_plan(scene, make_groups(scene), {});
    EXPECT_NEAR(plan.groups[1].packed_top, 2, 1e-15);
    EXPECT_NE(to_text(plan).find("% of the volume of their region, which ends at z = 2 m"), std::string::npos);
}

} // namespace
} // namespace skein
