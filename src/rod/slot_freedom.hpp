// Held directions of a rod's slots, by its ends and by what holds it inside. theory.md (47), (47a)
#pragma once

#include "skein/rod/rod_group.hpp"

#include <array>
#include <vector>

namespace skein {

/// Directions of a node and its element: 1 where they are free, 0 where held.
struct SlotFreedom {
    std::array<double, 6> free{1, 1, 1, 1, 1, 1}; ///< node and element, along lab axes
    bool turns_in_lab = false;                    ///< the element is held about some lab axes and free about others

    /// Number in `free` of the only axis about which such an element is held; -1 where there are two.
    int only_held_axis() const {
        if (!turns_in_lab || free[3] + free[4] + free[5] < 2) return -1;
        return free[3] == 0 ? 3 : free[4] == 0 ? 4 : 5;
    }
};

/// Freedom of all slots, [slots]. The last slot of a rod has no element to turn; a body is free.
std::vector<SlotFreedom> slot_freedoms(const RodGroup& group);

} // namespace skein
