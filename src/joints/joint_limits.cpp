#include "joints/joint_limits.hpp"

#include "joints/cluster_joints.hpp"
#include "rod/time_limits.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

namespace skein {

namespace {

/// Response of an element to a unit force at a joint's point, 1/kg, and to a unit couple, 1/(kg m^2). Nodes have the
/// mass that the element brings.
struct Mobility {
    double shift, turn;
};
Mobility mobility(const RodGroup& of_end, const JointEnd& end) {
    const RodGroup& group = of_end.kind(end.rod);
    const ElementConstants& c = nth(group.element, end.element);
    const double softest = std::max({c.inv_inertia.x, c.inv_inertia.y, c.inv_inertia.z});
    const double of_node = group.strained() ? 0.5 * group.spec().material.density * c.volume : group.node_mass.front();
    const double before = 1 - end.share;
    return {(before * before + end.share * end.share) / of_node + dot(end.arm, end.arm) * softest, softest};
}

/// Bound of the stiffness beside junctions. A spring K between two elements of inertia J and J' holds each with at most
/// K (1/J + 1/J'). A star takes the least J' of the others.
void bound_stars(const Junctions& junctions, std::span<const RodGroup> groups, std::vector<JointBounds>& bounds) {
    std::vector<std::map<std::pair<std::int64_t, int>, Vec3d>> held(groups.size());
    for (const Star& star : junctions.stars) {
        const auto inertia = [&](const Star::Member& m) -> const Vec3d& {
            return nth(nth(groups, m.group).kind(m.rod).element, m.element).inertia;
        };
        const auto add = [&](const Star::Member& m, int element, double stiffness, double others) {
            const Vec3d& j = inertia(m);
            const auto [at, fresh] = nth(held, m.group).try_emplace({m.rod, element}, Vec3d{0, 0, 0});
            const auto about = [&](double of_axis) { return stiffness * (1 / of_axis + others); };
            at->second += Vec3d{about(j.x), about(j.y), about(j.z)};
        };
        const bool pair = star.members.size() == 2 && star.along_axes;
        for (std::size_t i = 0; i < star.members.size(); ++i) {
            const Star::Member& m = star.members[i];
            if (pair && !star.rigid) { // axis by axis, as the cell between them
                const Star::Member& other = star.members[1 - i];
                const Vec3d &a = m.stiffness, &b = other.stiffness, &j = inertia(m), &l = inertia(other);
                const bool crossed =
                    std::abs(star.members[1].turn.d1.x) < 0.9; // d1 of one is not along that of the other
                const double bx = crossed ? std::max(b.x, b.y) : b.x, by = crossed ? bx : b.y,
                             ax = crossed ? std::max(a.x, a.y) : a.x, ay = crossed ? ax : a.y,
                             lx = crossed ? std::min(l.x, l.y) : l.x, ly = crossed ? lx : l.y;
                nth(held, m.group).try_emplace({m.rod, m.element}, Vec3d{0, 0, 0}).first->second +=
                    Vec3d{ax * bx / (ax + bx) * (1 / j.x + 1 / lx), ay * by / (ay + by) * (1 / j.y + 1 / ly),
                          a.z * b.z / (a.z + b.z) * (1 / j.z + 1 / l.z)};
                continue;
            }
            double others = 0;
            for (std::size_t k = 0; k < star.members.size(); ++k)
                if (k != i) {
                    const Vec3d& j = inertia(star.members[k]);
                    others = std::max(others, 1 / std::min({j.x, j.y, j.z}));
                }
            add(m, m.element, star.largest, others);
        }
    }
    for (std::size_t g = 0; g < groups.size(); ++g)
        for (const auto& [place, by] : held[g]) {
            const double eigenvalue = groups[g].strained()
                                          ? eigenvalue_of_element(groups[g].kind(place.first), place.second, by)
                                          : std::max({by.x, by.y, by.z});
            if (eigenvalue > bounds[g].eigenvalue) {
                bounds[g].eigenvalue = eigenvalue;
                bounds[g].element_of_eigenvalue = place.second;
            }
        }
}

} // namespace

double slider_way(const JointSpec& table, const Joint& joint) {
    const double reach = table.axis_law.reach();
    return reach > 0 ? reach : std::max(norm(joint.first.arm), norm(joint.second.arm));
}

namespace {

/// Stiffness and drag of free axes together, of a spherical joint with its cone. A twist turns by 1/cos(swing/2) faster
/// than the side.
struct AxesBound {
    double stiffness, drag;
};
AxesBound axes_bound(const JointSpec& table) {
    const AxisSpec &first = table.axis_law, &second = table.about_second;
    AxesBound bound{first.stiffness_bound() + second.stiffness_bound(), first.drag_bound() + second.drag_bound()};
    if (table.law.cone > 0) {
        const double cosine = std::cos(0.55 * table.law.cone), // a tenth beyond the cone
            stops = (first.limits.empty() ? 0 : 1 / (cosine * cosine) - 1) + 1;
        bound.stiffness += stops * first.stop_stiffness;
        bound.drag += stops * first.stop_damping;
    }
    return bound;
}

/// End of a joint with its longest lever. That of a slider's second side, and of a bushing's first, grows by the way.
JointEnd at_full_reach(const JointSpec& table, const Joint& joint, const JointEnd& end) {
    const JointEnd* grows = table.kind == JointKind::slider    ? &joint.second
                            : table.kind == JointKind::bushing ? &joint.first
                                                               : nullptr;
    JointEnd reached = end;
    if (grows == &end) reached.arm = {norm(end.arm) + slider_way(table, joint), 0, 0};
    return reached;
}

} // namespace

std::vector<JointBounds> joint_bounds(std::span<const JointSpec> tables, std::span<const std::vector<Joint>> joints,
                                      std::span<const RodGroup> groups) {
    struct Sums {
        double stiffness = 0, drag = 0;
    };
    std::vector<std::map<std::pair<std::int64_t, int>, Sums>> of_element(groups.size());
    for (const std::vector<Joint>& assembly : joints)
        for (const Joint& joint : assembly) {
            const JointSpec& table = tables[joint.table];
            const bool turns = turn_of(table) != JointTurn::none;
            // Stiffness of a repulsion where elements are a tenth closer than they were.
            const double repelling = 1.5 * table.law.repulsion * std::sqrt(0.1 * joint.rest_distance);
            for (const JointEnd* end : {&joint.first, &joint.second}) {
                if (end->of_world()) continue;
                const RodGroup& group = nth(groups, end->group);
                const Mobility m = mobility(group, at_full_reach(table, joint, *end));
                JointEnd centre = *end;
                centre.share = group.strained() ? 0.5 : 0;
                centre.arm = {0, 0, 0};
                Sums& sums = nth(of_element, end->group)[{end->rod, end->element}];
                sums.stiffness += 2 * (table.law.stiffness * m.shift + repelling * mobility(group, centre).shift +
                                       (turns ? table.law.torsional_stiffness * m.turn : 0));
                sums.drag += 2 * (table.law.damping * m.shift + (turns ? table.law.torsional_damping * m.turn : 0));
                if (form_of(table) == JointForm::spring) continue;
                const double per = turns_freely(table.kind) ? m.turn : m.shift;
                const AxesBound axes = axes_bound(table);
                sums.stiffness += 2 * axes.stiffness * per;
                sums.drag += 4 * axes.drag * per; // rates are extrapolated
            }
        }
    std::vector<JointBounds> bounds(groups.size());
    for (const std::vector<Joint>& assembly : joints)
        bound_stars(junctions_of(tables, assembly, groups), groups, bounds);
    for (std::size_t g = 0; g < groups.size(); ++g)
        for (const auto& [place, sums] : of_element[g]) {
            if (sums.stiffness > bounds[g].stiffness) {
                bounds[g].stiffness = sums.stiffness;
                bounds[g].element = place.second;
            }
            bounds[g].drag = std::max(bounds[g].drag, sums.drag);
        }
    return bounds;
}

std::vector<JointHolds> joint_holds(std::span<const JointSpec> tables, std::span<const std::vector<Joint>> joints,
                                    std::span<const RodGroup> groups) {
    std::vector<std::map<std::int64_t, JointHolds>> of_rod(groups.size());
    for (const std::vector<Joint>& assembly : joints)
        for (const Joint& joint : assembly) {
            const JointSpec& table = tables[joint.table];
            const double of_axes = axes_bound(table).stiffness;
            const bool about = turns_freely(table.kind);
            const double along = table.law.stiffness + (about ? 0 : of_axes),
                         turning = table.law.torsional_stiffness + (about ? of_axes : 0);
            for (const JointEnd* end : {&joint.first, &joint.second}) {
                if (end->of_world()) continue;
                const RodGroup& group = nth(groups, end->group);
                JointHolds& holds = nth(of_rod, end->group)[end->rod];
                holds.node.resize(to_index(group.elements()) + 1);
                holds.turn.resize(to_index(group.elements()));
                const Vec3d arm = at_full_reach(table, joint, *end).arm;
                const auto k = to_index(end->element);
                holds.node[k] += 4 * along * (1 - end->share);
                holds.node[std::min(k + 1, holds.node.size() - 1)] += 4 * along * end->share;
                holds.turn[k] += 4 * along * dot(arm, arm) + 2 * turning;
            }
        }
    for (const std::vector<Joint>& assembly : joints)
        for (const Star& star : junctions_of(tables, assembly, groups).stars)
            for (const Star::Member& m : star.members)
                if (m.length > 0) nth(nth(of_rod, m.group)[m.rod].turn, m.element) += 2 * star.largest;
    std::vector<JointHolds> largest(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g)
        for (const auto& [rod, holds] : of_rod[g]) {
            largest[g].node.resize(holds.node.size());
            largest[g].turn.resize(holds.turn.size());
            const auto raise = [](std::vector<double>& most, const std::vector<double>& by) {
                for (std::size_t i = 0; i < by.size(); ++i) most[i] = std::max(most[i], by[i]);
            };
            raise(largest[g].node, holds.node);
            raise(largest[g].turn, holds.turn);
        }
    return largest;
}

double star_energy(const Star& star,
                   const std::function<std::pair<Slot<1>, Slot<1>>(int, std::int64_t, int)>& element_of) {
    using P = Pack<1>;
    StarElements<P> now;
    StarLoads<P> loads;
    for (std::size_t i = 0; i < star.members.size(); ++i) {
        const Star::Member& m = star.members[i];
        const auto [slot, next] = element_of(m.group, m.rod, m.element);
        now[i] = {slot.director, next.position - slot.position, {}};
    }
    P energy(0.0);
    with_energy_law(star.law, [&]<class L>(L) { star_loads<L, 1>(star, false, now, loads, &energy); });
    return energy[0];
}

bool has_ended(std::span<const double> memory) {
    JointMemory<double> numbers{};
    if (!memory.empty()) std::memcpy(&numbers, memory.data(), sizeof numbers);
    return numbers.state == 2;
}

JointState joint_state(const JointSpec& table, const Joint& joint, const Slot<1>& a, const Slot<1>& a_next,
                       const Slot<1>& b, const Slot<1>& b_next, double time, std::int64_t rod,
                       std::span<const double> memory) {
    using P = Pack<1>;
    const JointConstants<double> c = constants_of(joint);
    const auto element = [](const Slot<1>& at, const Slot<1>& next, double share, double before, const Vec3d& arm,
                            const Vec3d& axis) {
        return JoinedElement<P>{at.position, next.position, at.velocity, next.velocity,     at.director,
                                at.spin,     P(share),      P(before),   broadcast<1>(arm), broadcast<1>(axis)};
    };
    JointFigures<P> figures;
    Quaternion<P> rest = broadcast<1>(c.rest);
    P length(c.rest_distance);
    auto first = element(a, a_next, c.share_a, c.share_before_a, c.arm_a, c.axis_a),
         second = element(b, b_next, c.share_b, c.share_before_b, c.arm_b, c.axis_b);
    AlignedVector<P> own(memory.begin(), memory.end()); // of a copy that goes on to this time
    const auto works = [&](JointState state) {
        if (own.empty()) return state;
        const AxesMemory<P> axes = axes_memory(own.data(), more_memory_numbers(table));
        state.motor_work = axes.first.motor_work[0];
        state.lost_work = axes.first.lost_work[0];
        const auto add = [&](const auto& of) {
            state.motor_work += of.motor_work[0];
            state.lost_work += of.lost_work[0];
        };
        if (axes.more && table.kind == JointKind::universal) add(*reinterpret_cast<AxisMemory<P>*>(axes.more));
        else if (axes.more) add(*reinterpret_cast<BallMemory<P>*>(axes.more));
        return state;
    };
    const auto force = [](const JointLoad<P>& load) { return norm(lane(load.force + load.push, 0)); };
    if (tears(table) && has_ended(memory)) return works({});
    if (table.events.any() && !tears(table)) {
        JointMemory<double> numbers{};
        if (!memory.empty()) std::memcpy(&numbers, memory.data(), sizeof numbers);
        if (numbers.state != 1) return works({});
        const JointRest<double>& made = numbers.made;
        first.arm = broadcast<1>(made.arm_a);
        first.axis = broadcast<1>(made.axis_a);
        second.arm = broadcast<1>(made.arm_b);
        second.axis = broadcast<1>(made.axis_b);
        rest = broadcast<1>(made.rest);
        length = P(made.length);
    }
    if (form_of(table) != JointForm::spring) {
        if (own.empty()) own.assign(memory_numbers(table), P(0.0)); // as before the first step
        JointLoad<P> other;
        const MotorsNow<P> motors = MotorsByRod<1>::spread(table.motors_at(time, static_cast<double>(rod)));
        const AxisAt<P> at{table.law, table.axis_law, table.about_second, motors, 0, table.to_world()};
        const JointLoad<P> load = with_form(table, [&]<JointForm Form>() {
            return form_load<Form, 1>(at, first, second, rest, length,
                                      axes_memory(own.data(), more_memory_numbers(table)), other, &figures);
        });
        return works({figures.energy[0], figures.gap[0], force(load)});
    }
    const JointLoad<P> load = with_joint(table, [&]<JointTurn Turn, bool Damped, bool Repels>() {
        JointLoad<P> other;
        return joint_load<Turn, Damped, Repels, 1>(table.law, first, second, rest, length, other, &figures);
    });
    return works({figures.energy[0], figures.gap[0], force(load)});
}

} // namespace skein
