// Numbers of slots, bodies and blocks against those of going through all bodies one by one.
#include "neighbourhood/scene_slots.hpp"

#include <gtest/gtest.h>

#include <random>

namespace skein {
namespace {

TEST(SceneSlots, AreThoseOfGoingThroughAllBodies) {
    std::mt19937 random(1);
    std::size_t shared = 0; // blocks with bodies of several groups
    for (int scene = 0; scene < 300; ++scene) {
        std::vector<SceneSlots::Alike> groups(1 + random() % 6);
        for (auto& g : groups)
            g = {static_cast<std::int64_t>(random() % 40),
                 2 + static_cast<std::int64_t>(random() % (scene % 3 ? 60 : 600))};
        groups.front().bodies += 1;
        const SceneSlots slots(groups);
        std::int64_t gid = 0, slot = 0, block = -1, begun = 0;
        int group_of_block = -1;
        for (std::size_t g = 0; g < groups.size(); ++g)
            for (std::int64_t i = 0; i < groups[g].bodies; ++i, ++gid) {
                if (block < 0 || slot + groups[g].slots - begun > slots.block_slots()) {
                    ++block;
                    begun = slot;
                    group_of_block = static_cast<int>(g);
                }
                shared += group_of_block != static_cast<int>(g);
                ASSERT_EQ(slots.group_of(gid), static_cast<int>(g));
                ASSERT_EQ(slots.first_slot(gid), slot);
                ASSERT_EQ(slots.slots_of(gid), groups[g].slots);
                ASSERT_EQ(slots.block_of(gid), block) << "scene " << scene << " body " << gid;
                for (const std::int64_t k : {std::int64_t{0}, groups[g].slots - 1})
                    ASSERT_EQ(slots.gid_at(slot + k), gid);
                slot += groups[g].slots;
            }
        EXPECT_EQ(slots.bodies(), gid);
        EXPECT_EQ(slots.count(), slot);
    }
    EXPECT_GT(shared, 100u);
}

} // namespace
} // namespace skein
