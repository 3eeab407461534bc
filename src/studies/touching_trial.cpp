#include "studies/touching_trial.hpp"

#include "parallel/threads.hpp"
#include "physics/fluid/stated_speeds.hpp"
#include "physics/implicit/implicit_tables.hpp"
#include "physics/loads/loads_with_formulas.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "simulation/world.hpp"
#include "skein/core/error.hpp"
#include "studies/cost_trial.hpp"
#include "tiles/clusters.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <limits>
#include <vector>

namespace skein {

namespace {

constexpr double longest_of_whole = 0.3, share_of_whole = 0.01; // s of wall time, of each method
constexpr double least_compared = 2;                            // s, by explicit steps
constexpr double fewest_implicit_steps = 64;                    // of the duration, of implicit steps

/// Time of contacts in beds once formed, per element and step, ns: a third of the bound of cost_trial.cpp; and that in
/// steps of a bed over it. nest_1536: 65 ns and 340 ns in all.
constexpr double ns_of_formed = 50, in_bed = 4.7;

/// Core time of this process: other programs may use the cores too.
double process_seconds() {
    std::timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Steps of a whole scene from its start on. Contacts that have yet to form are allowed for.
struct Tried {
    double step_s = 0;      ///< wall time of a step or part
    double parts = 1;       ///< of a step: of the last one, or in the mean if they were more
    double speed = 0;       ///< of the fastest node so far, m/s
    double way = HUGE_VAL;  ///< that a node may go in a part, m
    double spent = 0;       ///< s
    std::int64_t steps = 0; ///< that were made
};

std::optional<Tried> try_whole(const PlannedMethod& method, double budget) {
    const Plan& plan = method.plan;
    const Threads threads(1); // more of them would wait for each other, on cores that others use too
    World world(Communicator::alone(), threads, std::vector<RodGroup>(method.groups.begin(), method.groups.end()), plan,
                Protocol::asynchronous, Balance::never);
    Tried tried;
    double began = process_seconds();
    const auto spent = [&] { return process_seconds() - began; };
    world.give_up_when([&] { return spent() > budget; });
    world.advance(1); // the first list, in memory that no one has touched
    std::int64_t warm = 0;
    if (!world.gave_up()) {
        warm = world.parts_made();
        began = process_seconds();
    }
    std::int64_t at_once = 1; // steps between events cost less than steps with one each
    const auto goes_on = [&] { return world.failure().empty() && !world.ended() && world.clock.done() < plan.steps; };
    while (!world.gave_up() && goes_on() && spent() < budget) {
        world.advance(std::min(plan.steps, world.clock.done() + at_once));
        tried.speed = std::max(tried.speed, fastest(world.interactions()));
        if (at_once < 64 && spent() < 0.05 * budget) at_once *= 2;
    }
    tried.spent = spent();
    const std::int64_t made = world.parts_made();
    if (!world.failure().empty() || made == warm) return std::nullopt;
    tried.steps = world.clock.done();
    const PaceControl* pace = pace_control(world.interactions());
    const double forming = 1e-9 * ns_of_formed * missing_pairs(world) * static_cast<double>(plan.elements);
    tried.step_s = tried.spent / static_cast<double>(made - warm) + (pace ? in_bed : 1.0) * forming;
    // A step that has just begun has one part, whatever the ones before had.
    const double steps = static_cast<double>(tried.steps + (world.gave_up() ? 1 : 0));
    tried.parts = std::max(static_cast<double>(world.parts_of_step()), static_cast<double>(made) / steps);
    if (pace) tried.way = pace->allowed();
    else if (step_control(world.interactions())) tried.way = way_in_a_part(world.interactions());
    return tried;
}

/// Largest speed that muscles and moved ends give rods, m/s; 0: the scene states none. It is asked for as in a fluid,
/// so light that its own speeds do not count.
double driven_speed(SceneSpec scene, std::span<const RodGroup> groups) {
    scene.fluid.emplace();
    scene.fluid->density = std::numeric_limits<double>::min();
    scene.immersion.coupling = RodCoupling::one_way;
    double most = 0;
    for (const StatedSpeed& one : stated_speeds(scene, groups, loads_with_formulas(scene)))
        if (!one.at_once) most = std::max(most, one.value);
    return most;
}

/// The scene by this integrator with a step, s, or its automatic one; none where it is refused.
std::optional<PlannedMethod> plan_by(const SceneSpec& scene, std::span<const RodGroup> groups, const Machine& machine,
                                     Integrator integrator, double dt = 0) {
    const SceneSpec changed = with_integrator(scene, integrator, dt);
    if (!accepts_integrator(changed)) return std::nullopt;
    try {
        return PlannedMethod(changed, groups, machine);
    } catch (const Error&) {
        return std::nullopt;
    }
}

/// Longest part of a step of second order while bodies touch, s.
double longest_touching_part(const Plan& by_verlet, Integrator integrator) {
    double limit = HUGE_VAL;
    for (const GroupPlan& group : by_verlet.groups)
        for (const TimeLimit& of : group.limits)
            if (of.mode == "contact") limit = std::min(limit, of.dt);
    return scheme_of(integrator).touching * limit;
}

/// Implicit steps to compare with. Those of second order have the length that contacts allow, all the time.
std::vector<std::optional<PlannedMethod>> implicit_plans(const Plan& own, const Plan& by_verlet, const SceneSpec& scene,
                                                         std::span<const RodGroup> groups) {
    std::vector<std::optional<PlannedMethod>> plans;
    if (own.integrator == Integrator::implicit_bed) {
        plans.emplace_back(std::in_place, own, groups);
        return plans;
    }
    const bool implicit = is_implicit(own.integrator);
    const Integrator integrator = implicit ? own.integrator : Integrator::implicit_damped;
    const double dt = std::min(longest_touching_part(by_verlet, integrator),
                               implicit ? own.dt : scene.time.duration / fewest_implicit_steps);
    plans.push_back(plan_by(scene, groups, own.machine, integrator, dt));
    if (!implicit) plans.push_back(plan_by(scene, groups, own.machine, Integrator::implicit_bed));
    return plans;
}

/// Time of a whole run by implicit steps: in as many parts as the trial had, or as driven rods need.
double seconds_by_steps(const Plan& plan, const Tried& tried, double driven) {
    // Speed of the fastest rod in a crowd over that of a free one; pit_1024: 0.14 and 0.8 m/s.
    constexpr double pushed = 6;
    const double by_speed = std::exp2(std::ceil(std::log2(std::max(1.0, pushed * driven * plan.dt / tried.way))));
    return static_cast<double>(plan.steps) * std::max(tried.parts, by_speed) * tried.step_s;
}

/// Notes whether there are objections.
class AnyObjection final : public Objections {
public:
    void add(std::string_view, const std::string&) override { any = true; }
    bool given(std::string_view) const override { return false; }
    bool any = false;
};

} // namespace

SceneSpec with_integrator(SceneSpec scene, Integrator integrator, double dt) {
    scene.time.integrator = integrator;
    scene.time.dt = dt;
    scene.time.force_dt = false;
    return scene;
}

bool accepts_integrator(const SceneSpec& scene) {
    AnyObjection objections;
    ImplicitTables::check(scene, objections);
    return !objections.any;
}

bool rods_touch(const SceneSpec& scene) {
    return scene.contact.has_value() ||
           std::any_of(scene.walls.begin(), scene.walls.end(), [](const Wall& wall) { return wall.servo.drives(); });
}

PlannedMethod::PlannedMethod(const SceneSpec& scene, std::span<const RodGroup> of_other, const Machine& machine)
    : made(assemblies_of(of_other).empty() ? std::vector<RodGroup>() : make_groups(scene)),
      groups(made.empty() ? of_other : std::span<const RodGroup>(made)), plan(make_plan(scene, groups, machine)) {}

PlannedMethod::PlannedMethod(Plan of_own, std::span<const RodGroup> of_own_groups)
    : groups(of_own_groups), plan(std::move(of_own)) {}

std::optional<MethodCosts> touching_costs(const Plan& own, const SceneSpec& scene, std::span<const RodGroup> groups) {
    const bool implicit = is_implicit(own.integrator);
    const auto of_explicit = implicit ? plan_by(scene, groups, own.machine, Integrator::verlet)
                                      : std::optional<PlannedMethod>(std::in_place, own, groups);
    if (!of_explicit || of_explicit->plan.predicted_s < least_compared) return std::nullopt;
    const Plan& other = of_explicit->plan;
    const double budget = std::min(longest_of_whole, share_of_whole * other.predicted_s);
    const auto explicit_steps = try_whole(*of_explicit, budget);
    if (!explicit_steps) return std::nullopt;
    MethodCosts costs;
    costs.of_explicit = {other.integrator, explicit_steps->step_s * static_cast<double>(other.steps), 0};
    costs.trial_s = explicit_steps->spent;
    const double driven = driven_speed(scene, groups);
    bool any = false;
    for (const auto& method : implicit_plans(own, other, scene, groups)) {
        const auto tried = method ? try_whole(*method, budget) : std::nullopt;
        if (!tried) continue;
        const Plan& plan = method->plan;
        const double seconds = seconds_by_steps(plan, *tried, driven);
        costs.trial_s += tried->spent;
        if (any && seconds >= costs.of_implicit.seconds) continue;
        any = true;
        costs.of_implicit = {plan.integrator, seconds, implicit && own.automatic_dt ? scene.time.tolerance : 0};
        costs.covered = static_cast<double>(tried->steps) / static_cast<double>(plan.steps);
    }
    return any ? std::optional(costs) : std::nullopt;
}

} // namespace skein
