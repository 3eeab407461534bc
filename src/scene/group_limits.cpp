#include "scene/group_limits.hpp"

#include "rod/time_limits.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

namespace skein {

namespace {

/// Combined effect of loads on the step: the sum of their rates or stiffnesses, over the inertia that kicks feel, told
/// of the load that has the largest.
struct Together {
    double sum = 0;
    DragRate largest;
    std::string_view label;
};
Together together(const GroupPlan& p, const RodGroup& group, DragRate (Load::*of)(const RodGroup&) const) {
    Together all;
    for (const Load& load : p.loads) {
        const DragRate one = (load.*of)(group);
        if (one.value > all.largest.value) {
            all.largest = one;
            all.label = load.label();
        }
        all.sum += one.value / p.effective_inertia();
    }
    return all;
}

/// Told where it takes more than 1 %, which is what the bounds are worth.
void limit_by_loads(GroupPlan& p, const Together& loads, double dt) {
    if (dt < 0.99 * p.limits.front().dt) p.limits.insert(p.limits.begin(), {loads.label, dt, loads.largest.element});
}

/// Drag at the velocity before the kick takes from the stable step: a mode of frequency w is stable while (h w/2)^2 + h
/// nu/2 < 1, with the scheme's own figures for 2. theory.md (38)
void limit_by_drag(GroupPlan& p, const RodGroup& group, const Scheme& scheme) {
    const Together drag = together(p, group, &Load::largest_rate);
    const double fastest = p.limits.front().dt, half = 0.5 * fastest * scheme.stability * drag.sum / scheme.drag;
    limit_by_loads(p, drag, fastest * (std::sqrt(1 + half * half) - half));
}

/// The stiffness of loads adds to that of the rod: w^2 grows by at most what all of them have over mass. theory.md
/// (40c)
void limit_by_stiffness(GroupPlan& p, const RodGroup& group) {
    const Together stiff = together(p, group, &Load::largest_stiffness);
    const double rate = 2 / p.limits.front().dt;
    limit_by_loads(p, stiff, 2 / std::sqrt(rate * rate + stiff.sum));
}

/// Joints of rods add to both.
void limit_by_joints(GroupPlan& p, const JointBounds& joints, const Scheme& scheme) {
    const auto limit = [&](double dt) {
        if (dt < 0.99 * p.limits.front().dt) p.limits.insert(p.limits.begin(), {"joints", dt, joints.element});
    };
    if (joints.eigenvalue > 0) { // beside a junction elements have one cell more than at an end
        const double dt = 2 / std::sqrt(joints.eigenvalue / p.effective_inertia());
        if (p.limits.empty() || dt < 0.99 * p.limits.front().dt)
            p.limits.insert(p.limits.begin(), {"joints", dt, joints.element_of_eigenvalue});
    }
    if (joints.stiffness > 0) {
        const double rate = p.limits.empty() ? 0 : 2 / p.limits.front().dt,
                     dt = 2 / std::sqrt(rate * rate + joints.stiffness / p.effective_inertia());
        if (p.limits.empty()) p.limits.push_back({"joints", dt, joints.element});
        else limit(dt);
    }
    if (joints.drag == 0) return;
    const double fastest = p.limits.front().dt,
                 half = 0.5 * fastest * scheme.stability * joints.drag / (scheme.drag * p.effective_inertia());
    limit(fastest * (std::sqrt(1 + half * half) - half));
}

/// The contact that leaves the shortest step, among all that a group may have.
void limit_by_contact(GroupPlan& p, const RodGroup& group, const SceneSpec& scene) {
    TimeLimit least{"contact", HUGE_VAL, 0};
    with_contact_laws(scene, group, [&](const ContactLaw& law, double share, double mass) {
        const TimeLimit limit = contact_time_limit(group, law.resolved(mass), share);
        if (limit.dt < least.dt) least = limit;
    });
    if (!std::isfinite(least.dt)) return;
    if (!group.strained()) p.limits.clear();
    p.limits.push_back(least);
    std::stable_sort(p.limits.begin(), p.limits.end(),
                     [](const TimeLimit& a, const TimeLimit& b) { return a.dt < b.dt; });
}

} // namespace

void find_limits(GroupPlan& p, const RodGroup& group, const SceneSpec& scene, const JointBounds* joints) {
    const Scheme scheme = scheme_of(scene.time.integrator);
    p.limits = time_limits(group);
    limit_by_contact(p, group, scene);
    for (TimeLimit& limit : p.limits) limit.dt *= std::sqrt(p.effective_inertia());
    limit_by_stiffness(p, group);
    limit_by_drag(p, group, scheme);
    if (joints) limit_by_joints(p, *joints, scheme);
}

} // namespace skein
