#include "contact/contact_solver.hpp"

#include "contact/contact_limits.hpp"
#include "contact/contact_spec.hpp"
#include "rod/body_shape.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace skein {

namespace {

/// Elements nearer along a body than half the way round its section touch only where it is folded.
SelfGap self_gap(const RodGroup& group, const ContactSpec& spec) {
    const std::int32_t ring = group.closed() ? group.elements() : 0;
    if (!spec.self || !group.strained()) return {.elements = -1, .ring = ring};
    double widest = 0, shortest = HUGE_VAL;
    for (const ElementConstants& c : group.element) {
        shortest = std::min(shortest, c.rest_length);
        widest = std::max(widest, c.radius);
    }
    const double gap = spec.self_gap > 0 ? spec.self_gap : std::numbers::pi * widest;
    return {.elements = static_cast<std::int32_t>(std::ceil(gap / shortest)) + 1, .ring = ring};
}

/// Largest mass of a rod over the mean of its group, which bounds the stiffness that a restitution gives to a pair; 1
/// where the bodies of each group are alike.
double heaviest_over_mean(const ContactScene& scene) {
    double most = 1;
    for (std::size_t g = 0; g < scene.own.size(); ++g)
        for (const double mass : scene.own[g].mass) most = std::max(most, mass / scene.masses[g]);
    return most;
}

} // namespace

ContactScene contact_scene(std::span<const RodGroup> groups, const ContactSpec& spec, ContactLaws laws,
                           std::shared_ptr<const JoinedGaps> joined) {
    ContactScene scene{std::move(laws), {}, 0, SceneSlots(groups).count(), {}};
    scene.rules.joined = std::move(joined);
    scene.thinnest = HUGE_VAL;
    double sum = 0, elements = 0, widest = 0;
    for (const RodGroup& group : groups) {
        scene.rules.of_group.push_back(self_gap(group, spec));
        scene.slip_mobility.push_back(slip_mobility(group));
        const auto add = [&](double radius, double bodies) {
            sum += bodies * 2 * radius;
            elements += bodies;
            scene.thinnest = std::min(scene.thinnest, radius);
            widest = std::max(widest, radius);
        };
        scene.masses.push_back(body_mass(group));
        if (group.heterogeneous()) {
            scene.rules.own.resize(groups.size());
            scene.own.resize(groups.size());
        }
        for_each_kind(group, [&](const RodGroup& kind, double bodies) {
            if (group.heterogeneous()) {
                scene.rules.own[to_index(group.id())].of_rod.push_back(self_gap(kind, spec));
                OwnMasses& own = scene.own[to_index(group.id())];
                own.mass.push_back(body_mass(kind));
                own.slip_mobility.push_back(slip_mobility(kind));
            }
            for (const ElementConstants& c : kind.element)
                if (group.strained()) add(c.radius, bodies);
        });
        if (group.heterogeneous()) {
            scene.rules.own[to_index(group.id())].first_gid = group.first_gid();
            scene.own[to_index(group.id())].first_gid = group.first_gid();
        }
        if (!group.body()) continue;
        for (const BodyShape::Part& part : group.body()->part) add(part.radius, static_cast<double>(group.count()));
        if (!group.body()->has_boxes()) continue;
        scene.boxes.resize(groups.size());
        for (const BodyShape::Part& part : group.body()->part)
            nth(scene.boxes, group.id()).push_back(part.box ? PartBox{part.half, part.radius} : PartBox{});
    }
    scene.diameter = elements > 0 ? sum / elements : 0;
    for (std::size_t i = 0; i < scene.laws.materials(); ++i)
        for (std::size_t j = 0; j < scene.laws.materials(); ++j)
            scene.largest_energy = std::max(scene.largest_energy, energy_at(scene.laws.between(i, j), 2 * widest));
    scene.largest_energy *= heaviest_over_mean(scene);
    return scene;
}

ContactNumbers<double> ContactScene::for_bodies(ContactNumbers<double> numbers, const Window& a,
                                                const Window& b) const {
    if (own.empty() || !numbers.by_mass) return numbers;
    const auto effective = [](double one, double two) { return 1 / (1 / one + 1 / two); };
    const double share = effective(mass_of(a), mass_of(b)) / effective(nth(masses, a.group), nth(masses, b.group));
    numbers.stiffness *= share;
    numbers.damping *= share;
    numbers.tangential_stiffness *= share;
    return numbers;
}

void ContactSolver::evaluate(const Exposure& bodies, double time, double h, SlotLoads& loads) {
    loads.load.resize(bodies.slots());
    if (!holds(bodies)) {
        prepare_rebuild(bodies);
        std::vector<std::uint8_t> wanted(bodies.slots());
        std::vector<std::uint32_t> same(bodies.slots());
        std::iota(same.begin(), same.end(), 0u);
        finish_rebuild(bodies, same, search(bodies, wanted));
    }
    loads.tangent.resize(loads.has_tangents ? bodies.slots() : 0);
    set_tangents(loads.tangent);
    begin(bodies, time, h, loads.load, false);
    finish(bodies, h, loads.load);
    loads.touched = touched();
}

} // namespace skein
