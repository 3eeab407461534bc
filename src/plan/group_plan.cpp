#include "plan/group_plan.hpp"

#include "core/share_text.hpp"
#include "mechanics/bending_shift.hpp"
#include "mechanics/law.hpp"
#include "plan/law_differences.hpp"
#include "rod/body_shape.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace skein {

namespace {

KickKind kick_of(const RodGroup& group, const DampingRates& rates, DampingScheme scheme) {
    if (group.law() == Law::elastica) return KickKind::elastica;
    if (rates.none()) return KickKind::undamped;
    if (!rates.follow_stretch()) return KickKind::constant_rates;
    switch (scheme) {
    case DampingScheme::midpoint:
        return KickKind::stretched_rates;
    case DampingScheme::exponential:
        return KickKind::stretched_exponential;
    case DampingScheme::after:
        break;
    }
    return KickKind::stretched_after;
}

/// The published law has the published order; kicks backwards need the exact flow.
DampingScheme damping_scheme_of(const RodGroup& group, const TimeSpec& time) {
    if (group.law() == Law::elastica) return DampingScheme::after;
    return time.integrator == Integrator::pefrl && time.damping == DampingScheme::midpoint ? DampingScheme::exponential
                                                                                           : time.damping;
}

std::vector<std::string> hints_for(const RodGroup& group) {
    std::vector<std::string> hints;
    if (!group.strained()) return hints;
    const Shape& shape = group.spec().shape;
    double length = group.element[0].rest_length, radius = group.element[0].radius;
    for (const ElementConstants& c : group.element)
        if (c.rest_length * radius < length * c.radius) {
            length = c.rest_length;
            radius = c.radius;
        }
    if (length < radius)
        hints.push_back(fmt::format(
            "elements are {:.2g} radii long; below 1 they cost time and gain little: elements = {} would do",
            length / radius, std::max(2L, static_cast<long>(static_cast<double>(shape.elements) * length / radius))));
    constexpr double longest_element = 1000; // radii; of hair in 20 elements 100
    if (length > longest_element * radius)
        hints.push_back(fmt::format(
            "elements are {:.2g} radii long, so that bends shorter than that are not seen; if the radius is right, "
            "elements = {:.2g} would have a hundred each",
            length / radius, static_cast<double>(shape.elements) * length / (100 * radius)));
    if (const auto told = law_differences(group)) hints.push_back(*told);
    if (group.spec().start == EndKind::clamped_frozen || group.spec().end == EndKind::clamped_frozen)
        hints.emplace_back(
            "\"clamped_frozen\" is of first order, an error of about 1/elements; \"clamped\" is of second "
            "order at the same cost");
    return hints;
}

/// Numbers of a group that no physics decides on.
void describe_rods(GroupPlan& p, const RodGroup& group) {
    p.tension_limit = tension_limit(group);
    if (const BodyShape* body = group.body())
        p.body = fmt::format("{:.4g} kg, J = ({:.4g}, {:.4g}, {:.4g}) kg m^2, {} part{}", body->mass, body->inertia.x,
                             body->inertia.y, body->inertia.z, body->part.size(), body->part.size() == 1 ? "" : "s");
    if (const auto& j = group.rotary_inertia_scale; !j.empty()) {
        const auto [least, largest] = std::minmax_element(j.begin(), j.end());
        p.least_rotary_scale = *least;
        p.largest_rotary_scale = *largest;
        p.bending_shift = bending_shift(group);
    }
    if (group.spec().placement.kind == PlacementKind::packing) {
        p.packed_fill = group.packed_fill();
        p.packed_top = group.packed_top();
    }
    p.deviation = group.places().deviation();
    p.hints = hints_for(group);
    const auto named = [](EndKind kind, const std::string& free) {
        return fmt::format("{}{}{}", nth(end_names, kind), free.empty() ? "" : ", free along ", free);
    };
    p.start = named(group.spec().start, group.spec().start_free);
    p.end = named(group.spec().end, group.spec().end_free);
}

/// Limits by the group's own modes, by what acts on it, and by how that changes the inertia and the modes.
void find_limits(GroupPlan& p, const RodGroup& group, const Scheme& scheme, const PhysicsPlans& physics) {
    p.limits = time_limits(group);
    for (const auto& one : physics) one->add_limits(p, group);
    for (TimeLimit& limit : p.limits) limit.dt *= std::sqrt(p.effective_inertia());
    for (const auto& one : physics) one->tighten_limits(p, group, scheme);
}

/// The plan of rods that have the constants of a group.
GroupPlan plan_alike(const TimeSpec& time, const RodGroup& group, const PhysicsPlans& physics, bool acts_between) {
    GroupPlan p{.name = group.name(), .rods = group.count(), .elements = group.elements()};
    if (group.assembly() && group.assembly()->lane_each) p.rods_of_lane = group.rods_per_copy();
    for (const auto& one : physics) one->act_on(p, group);
    p.damping_scheme = damping_scheme_of(group, time);
    const DampingRates rates = damping_rates(group, p.damping);
    p.kick = kick_of(group, rates, p.damping_scheme);
    p.undamped = group.law() == Law::elastica ? p.damping.empty() : rates.none();
    p.program = program_of(group, p, acts_between);
    for (const auto& one : physics) one->add_passes(p, group);
    for (const PassSpec& pass : p.program) p.ns_per_element_step += pass.ns;
    find_limits(p, group, scheme_of(time.integrator), physics);
    describe_rods(p, group);
    return p;
}

/// Takes from the plan of one more rod what is worse there.
void take_worse(GroupPlan& p, const GroupPlan& rod) {
    for (const TimeLimit& limit : rod.limits) {
        const auto same = std::find_if(p.limits.begin(), p.limits.end(),
                                       [&](const TimeLimit& other) { return other.mode == limit.mode; });
        if (same == p.limits.end()) p.limits.push_back(limit);
        else if (!(limit.dt >= same->dt)) *same = limit;
    }
    if (rod.inertia) p.inertia = std::min(p.effective_inertia(), *rod.inertia);
    p.undamped = p.undamped && rod.undamped;
    p.tension_limit = std::min(p.tension_limit, rod.tension_limit);
    p.least_rotary_scale = std::min(p.least_rotary_scale, rod.least_rotary_scale);
    p.largest_rotary_scale = std::max(p.largest_rotary_scale, rod.largest_rotary_scale);
    p.bending_shift = std::max(p.bending_shift, rod.bending_shift);
}

OwnSizes laid_out(const GroupProgram& program) {
    const auto all = [&](auto of) { return std::all_of(program.begin(), program.end(), of); };
    if (!all([](const PassSpec& pass) { return (pass.lies_along || pass.lies_whole) && !pass.has_tables; }))
        return OwnSizes::apart;
    return program.lies_along() ? OwnSizes::cut : OwnSizes::whole;
}

/// Limits of rods with sizes of their own are the least of all.
void find_least_limits(GroupPlan& p, const TimeSpec& time, const RodGroup& group, const PhysicsPlans& physics,
                       bool acts_between) {
    if (!group.places().holds_all()) throw std::logic_error("a plan of rods of which not all are known");
    p.limits.clear();
    p.tension_limit = HUGE_VAL;
    for_each_kind(group,
                  [&](const RodGroup& rod, double) { take_worse(p, plan_alike(time, rod, physics, acts_between)); });
    std::stable_sort(p.limits.begin(), p.limits.end(),
                     [](const TimeLimit& a, const TimeLimit& b) { return a.dt < b.dt; });
}

} // namespace

void GroupPlan::limit(std::string_view mode, double dt, int element) {
    if (limits.empty() || dt < 0.99 * limits.front().dt) limits.insert(limits.begin(), {mode, dt, element});
}

GroupPlan plan_group(const TimeSpec& time, const RodGroup& group, const PhysicsPlans& physics, bool acts_between) {
    GroupPlan p = plan_alike(time, group, physics, acts_between);
    if (!group.heterogeneous()) return p;
    p.own_sizes = laid_out(p.program);
    if (p.own_sizes != OwnSizes::cut || p.limited_by_loads || group.spec().material.inertia_chosen)
        find_least_limits(p, time, group, physics, acts_between);
    return p;
}

GroupPlan plan_of_rod(const Plan& plan, const RodGroup& rod) {
    TimeSpec time;
    time.integrator = plan.integrator;
    time.damping = nth(plan.groups, rod.id()).damping_scheme;
    return plan_alike(time, rod, plan.physics, plan.acts_between_rods());
}

int find_families(std::span<GroupPlan> groups) {
    std::vector<std::string> keys;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        GroupPlan& p = groups[g];
        const bool own = p.own_sizes != OwnSizes::none;
        if (own ? p.own_sizes == OwnSizes::apart : !p.program.lies_along()) continue;
        std::string key = own ? fmt::format("{}", g) : std::string();
        for (const PassSpec& pass : p.program) key += fmt::format("|{} {}", pass.name, pass.family);
        const auto found = std::find(keys.begin(), keys.end(), key);
        p.family = static_cast<int>(found - keys.begin());
        if (found == keys.end()) keys.push_back(key);
    }
    return static_cast<int>(keys.size());
}

} // namespace skein
