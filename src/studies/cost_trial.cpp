#include "studies/cost_trial.hpp"

#include "core/memory.hpp"
#include "core/timer.hpp"
#include "parallel/threads.hpp"
#include "physics/contact/contact_interaction.hpp"
#include "physics/contact/contact_plan.hpp"
#include "plan/plan_words.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_rebuild.hpp"
#include "simulation/start.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace skein {

namespace {

constexpr std::int64_t least_steps = 50;
constexpr double least_seconds = 0.2, most_seconds = 3; // wall time
constexpr double most_memory = 0.25;                    // share of what is free
/// Beds of any shape, once formed: pairs that touch, per element, and time of a pair with its share of the search on
/// one core, ns (docs/performance.md).
constexpr double pairs_of_bed = 1, ns_of_pair = 190;

double touching_pairs(const World& world) {
    const ContactInteraction* contacts = contacts_of(world.interactions());
    for (const Figure& figure : contacts->figures({}))
        if (figure.name.starts_with("touching_pairs")) return figure.terms.front();
    return 0;
}

/// Touching pairs per element.
double touching_share(const World& world) { return touching_pairs(world) / static_cast<double>(world.plan.elements); }

} // namespace

double missing_pairs(const World& world) {
    const auto* touch = world.plan.find<TouchPlan>();
    if (!touch || touch->estimate.by.empty() || !contacts_of(world.interactions())) return 0;
    const double share = touching_share(world);
    return share < 0.5 * pairs_of_bed ? pairs_of_bed - share : 0;
}

bool cost_is_measured(const Plan& plan) {
    const bool beside_fluid = std::any_of(plan.physics.begin(), plan.physics.end(),
                                          [&](const auto& one) { return one->core_seconds(plan) > 0; });
    return plan.has<ContactPlan>() && !beside_fluid && plan.machine.ranks == 1 && plan.steps > 1 &&
           plan.state_bytes < most_memory * free_memory();
}

void measure_cost(Plan& plan, const SceneSpec& scene, std::vector<RodGroup> groups, const std::string& directory) {
    const Threads threads(std::min(plan.machine.threads, Threads::available_cores()));
    const std::string physics = physics_json(resolved(scene, groups), groups, plan.dt);
    Stages stages(scene, groups);
    World world(Communicator::alone(), threads, std::move(groups), plan, Protocol::asynchronous, Balance::never);
    const Start start = start_of(world, stages, scene, physics, {.out = directory});
    const std::int64_t first = world.clock.done(), all = world.plan.steps;
    const double start_time = world.clock.time();
    const auto left = static_cast<double>(all - first);
    const auto advance = [&](std::int64_t steps) {
        world.advance(std::min(all, world.clock.done() + steps));
        return world.failure().empty() && world.clock.done() < all && !world.ended();
    };
    double began = wall_seconds();
    const auto spent = [&] { return wall_seconds() - began; };
    world.give_up_when([&] { return spent() > most_seconds; });
    if (!advance(1)) return; // the first list, in memory that no one has touched
    if (!world.gave_up()) began = wall_seconds();
    const std::int64_t warm = world.clock.done(), warm_parts = world.gave_up() ? 0 : world.parts_made();
    const auto made = [&] { return world.clock.done() - warm; };
    std::int64_t at_once = 1; // steps between events cost less than steps with one each
    while (!world.gave_up() && advance(at_once) && spent() < most_seconds &&
           (made() < least_steps || spent() < least_seconds))
        if (at_once < 64 && spent() * static_cast<double>(at_once) < 0.1 * least_seconds * static_cast<double>(made()))
            at_once *= 2;
    const std::int64_t parts = std::max<std::int64_t>(1, world.parts_made() - warm_parts);
    if (made() == 0 && !world.gave_up()) return;
    const double of_step = world.gave_up()
                               ? spent() * static_cast<double>(world.parts_of_step()) / static_cast<double>(parts)
                               : spent() / static_cast<double>(made());
    plan.predicted_s = left * of_step;
    plan.predicted_by =
        fmt::format("{}{}, {:.2g} pairs touch an element",
                    world.gave_up() ? counted(parts, "part") + " of a step" : counted(made(), "step"),
                    start.found ? fmt::format(" from {:.4g} s on", start_time) : "", touching_share(world));
    if (const double missing = missing_pairs(world); missing > 0)
        plan.predicted_most_s = plan.predicted_s + 1e-9 * left * missing * static_cast<double>(plan.elements) *
                                                       ns_of_pair / threads.count();
}

} // namespace skein
