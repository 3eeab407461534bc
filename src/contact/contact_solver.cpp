#include "contact/contact_solver.hpp"

#include "contact/contact_spec.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace skein {

namespace {

/// Elements nearer along a body than half the way round its section touch only where it is folded.
std::int32_t self_gap(const RodGroup& group, const ContactSpec& spec) {
    if (!spec.self || !group.strained()) return -1;
    double widest = 0, shortest = HUGE_VAL;
    for (const ElementConstants& c : group.element) {
        shortest = std::min(shortest, c.rest_length);
        widest = std::max(widest, c.radius);
    }
    const double gap = spec.self_gap > 0 ? spec.self_gap : std::numbers::pi * widest;
    return static_cast<std::int32_t>(std::ceil(gap / shortest)) + 1;
}

} // namespace

ContactScene contact_scene(std::span<const RodGroup> groups, const ContactSpec& spec, ContactLaws laws) {
    ContactScene scene{std::move(laws), {}, 0, SceneSlots(groups).count()};
    double sum = 0, elements = 0;
    for (const RodGroup& group : groups) {
        scene.gaps.push_back(self_gap(group, spec));
        const auto bodies = static_cast<double>(group.count());
        for (int slot = 0; slot < group.exposed_slots(); ++slot) {
            const double radius = group.exposed_radius(slot);
            if (radius < 0) continue;
            sum += bodies * 2 * radius;
            elements += bodies;
        }
    }
    scene.diameter = elements > 0 ? sum / elements : 0;
    return scene;
}

void ContactSolver::evaluate(const Exposure& bodies, double time, double h, SlotLoads& loads) {
    loads.load.resize(bodies.slots());
    if (!lasts() || !begin(bodies, time, h, loads.load, true)) {
        let_go(bodies);
        std::vector<std::uint8_t> wanted(bodies.slots());
        std::vector<std::uint32_t> same(bodies.slots());
        std::iota(same.begin(), same.end(), 0u);
        settle(bodies, same, search(bodies, wanted));
        begin(bodies, time, h, loads.load, false);
    }
    finish(bodies, h, loads.load);
    loads.touched = touched();
}

} // namespace skein
