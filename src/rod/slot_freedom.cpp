#include "rod/slot_freedom.hpp"

#include "skein/core/index.hpp"

#include <string>

namespace skein {

std::vector<SlotFreedom> slot_freedoms(const RodGroup& group) {
    std::vector<SlotFreedom> all(to_index(group.slots()));
    if (!group.strained()) return all;
    const int n = group.elements(), nodes = group.nodes();
    for (int k = 0; k <= n; ++k) {
        auto& free = nth(all, k).free;
        if (group.holds_node(k)) free[0] = free[1] = free[2] = 0;
        if (group.slides(k)) {
            const Vec3d open = group.free_directions(k);
            free[0] = open.x;
            free[1] = open.y;
            free[2] = open.z;
        }
        if (k == n || group.holds_element(k)) free[3] = free[4] = free[5] = 0;
    }
    const auto hold_axes = [](double* free, const std::string& axes) {
        for (const char axis : axes) free[axis - 'x'] = 0;
    };
    const Hold& hold = group.spec().hold;
    for (const long i : hold.nodes) hold_axes(&nth(all, i < 0 ? nodes + i : i).free[0], hold.directions);
    for (const long k : hold.elements) {
        SlotFreedom& slot = nth(all, k < 0 ? n + k : k);
        hold_axes(&slot.free[3], hold.axes);
        slot.turns_in_lab = slot.free[3] + slot.free[4] + slot.free[5] > 0;
    }
    return all;
}

} // namespace skein
