// Slots of the exposure in states of bodies at rest: nodes of rods, and places on rigid bodies.
#pragma once

#include "neighbourhood/exposure.hpp"
#include "rod/body_shape.hpp"
#include "skein/core/index.hpp"
#include "tiles/rods.hpp"

#include <vector>

namespace skein {

struct AttachedSlot {
    std::size_t slot;                     ///< of the state
    bool on_body = false;                 ///< at `arm` of a rigid body
    Vec3d arm{0, 0, 0};                   ///< body, m
    const BodyShape::Part* box = nullptr; ///< whose centre it is

    Vec3d place(const Slot<1>& at) const {
        const Vec3d centre = lane(at.position, 0);
        return on_body ? centre + transpose_times(lane(at.director, 0), arm) : centre;
    }
};

/// By slot of the exposure of `rods`, whose states stand one after another. The last node of a ring is its first one.
inline std::vector<AttachedSlot> attached_slots(const Exposure& bodies, std::span<const RodGroup> groups,
                                                std::span<const LocalRod> rods) {
    std::vector<AttachedSlot> all(bodies.slots());
    std::size_t first = 0;
    for (std::size_t i = 0; i < rods.size(); ++i) {
        const RodGroup& group = nth(groups, rods[i].group);
        const Window& window = bodies.window[bodies.number_of_own(i)];
        for (std::uint32_t k = 0; k < window.slots; ++k) {
            AttachedSlot& one = all[window.first_slot + k];
            if (const BodyShape* body = group.body()) {
                const BodyShape::Part& part = body->part[k / 2];
                one = {first, true, k % 2 == 0 ? part.from : part.to, part.box ? &part : nullptr};
            } else {
                one = {first + (group.closed() && k + 1 == window.slots ? 0 : k)};
            }
        }
        first += to_index(group.slots());
    }
    return all;
}

} // namespace skein
