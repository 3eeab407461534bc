// Windows in order, slots found by their numbers in the scene, and what own bodies show while windows of ghosts come
// and go.
#include "neighbourhood/exposure.hpp"

#include <gtest/gtest.h>

namespace skein {
namespace {

const SceneSlots::Alike groups[] = {{4, 5}, {2, 9}};

Window body(std::int64_t gid, bool own) {
    const SceneSlots scene{groups};
    return {gid, scene.first_slot(gid), 0, static_cast<std::uint32_t>(scene.slots_of(gid)), scene.group_of(gid), own};
}

TEST(Exposure, FindsSlotsByTheirNumbersInTheScene) {
    const SceneSlots scene{groups};
    Window part = body(5, false); // elements 2 and 3 of a ghost, and the node behind
    part.first_in_scene += 2;
    part.slots = 3;
    const Exposure bodies(scene, {body(1, true), body(3, true), part});
    ASSERT_EQ(bodies.slots(), 5u + 5 + 3);
    EXPECT_EQ(bodies.find(4), std::nullopt);
    EXPECT_EQ(bodies.find(5), 0u);
    EXPECT_EQ(bodies.find(9), 4u);
    EXPECT_EQ(bodies.find(10), std::nullopt) << "of a body that is not here";
    EXPECT_EQ(bodies.find(15), 5u);
    EXPECT_EQ(bodies.find(scene.first_slot(5) + 1), std::nullopt) << "of an element that is not here";
    EXPECT_EQ(bodies.find(scene.first_slot(5) + 4), 12u);
    EXPECT_EQ(bodies.find(scene.first_slot(5) + 5), std::nullopt);
    for (std::size_t slot = 0; slot < bodies.slots(); ++slot) EXPECT_EQ(bodies.find(bodies.in_scene(slot)), slot);
    EXPECT_EQ(bodies.element(11), 3);
    EXPECT_TRUE(bodies.owns_slot(9));
    EXPECT_FALSE(bodies.owns_slot(10));
}

TEST(Exposure, KeepsWhatOwnBodiesShow) {
    const SceneSlots scene{groups};
    Exposure bodies(scene, {body(1, true), body(4, true)});
    for (std::size_t slot = 0; slot < bodies.slots(); ++slot) {
        bodies.node[slot].position = {static_cast<double>(bodies.in_scene(slot)), 0, 0};
        bodies.motion[slot].velocity = {0, static_cast<double>(bodies.in_scene(slot)), 0};
    }
    bodies.become(Exposure(scene, {body(0, false), body(1, true), body(2, false), body(4, true), body(5, false)}));
    bodies.become(Exposure(scene, {body(1, true), body(3, false), body(4, true)}));
    for (const std::size_t w : {std::size_t{0}, std::size_t{2}})
        for (std::size_t slot = bodies.window[w].first_slot; slot < bodies.end_of(w); ++slot) {
            EXPECT_EQ(bodies.node[slot].position.x, static_cast<double>(bodies.in_scene(slot)));
            EXPECT_EQ(bodies.motion[slot].velocity.y, static_cast<double>(bodies.in_scene(slot)));
        }
}

} // namespace
} // namespace skein
