#include "contact/exposure.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

Exposure::Exposure(std::span<const RodGroup> groups, const ContactSpec& spec, std::size_t materials) {
    for (const RodGroup& group : groups) {
        double widest = 0, shortest = HUGE_VAL;
        for (const ElementConstants& c : group.element) {
            shortest = std::min(shortest, c.rest_length);
            widest = std::max(widest, c.radius);
        }
        // Elements nearer along the rod than half the way round its section touch only where it is folded.
        const double gap = spec.self_gap > 0 ? spec.self_gap : std::numbers::pi * widest;
        const auto skip = spec.self ? static_cast<std::int32_t>(std::ceil(gap / shortest)) + 1 : -1;
        for (std::int64_t i = 0; i < group.count(); ++i) {
            const auto rod = static_cast<std::int32_t>(capsules.first_slot.size());
            capsules.first_slot.push_back(static_cast<std::int32_t>(capsules.node.size()));
            capsules.skip.push_back(skip);
            if (materials > 1) capsules.material.push_back(group.id());
            for (int k = 0; k < group.slots(); ++k) {
                const bool is_element = k < group.elements();
                capsules.node.push_back({{}, is_element ? group.element[static_cast<std::size_t>(k)].radius : -1});
                capsules.rod.push_back(rod);
            }
        }
    }
    capsules.first_slot.push_back(static_cast<std::int32_t>(capsules.node.size()));
    capsules.motion.resize(capsules.node.size());
}

} // namespace skein
