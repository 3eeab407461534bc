#include "joints/joint_limits.hpp"

#include "joints/cluster_joints.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace skein {

namespace {

/// What a unit force at a joint's point does to its element, 1/kg, and a unit couple, 1/(kg m^2). A node's mass is that part of it
/// which the element brings.
struct Mobility {
    double shift, turn;
};
Mobility mobility(const RodGroup& group, const JointEnd& end) {
    const ElementConstants& c = group.element[static_cast<std::size_t>(end.element)];
    const double softest = std::max({c.inv_inertia.x, c.inv_inertia.y, c.inv_inertia.z});
    const double of_node = group.strained() ? 0.5 * group.spec().material.density * c.volume : group.node_mass.front();
    const double before = 1 - end.share;
    return {(before * before + end.share * end.share) / of_node + dot(end.arm, end.arm) * softest, softest};
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
            // Of a repulsion where elements are a tenth closer than they were.
            const double repelling = 1.5 * table.law.repulsion * std::sqrt(0.1 * joint.rest_distance);
            for (const JointEnd* end : {&joint.first, &joint.second}) {
                const RodGroup& group = groups[static_cast<std::size_t>(end->group)];
                const Mobility m = mobility(group, *end);
                JointEnd centre = *end;
                centre.share = group.strained() ? 0.5 : 0, centre.arm = {0, 0, 0};
                Sums& sums = of_element[static_cast<std::size_t>(end->group)][{end->rod, end->element}];
                sums.stiffness += 2 * (table.law.stiffness * m.shift + repelling * mobility(group, centre).shift +
                                       (turns ? table.law.torsional_stiffness * m.turn : 0));
                sums.drag += 2 * (table.law.damping * m.shift + (turns ? table.law.torsional_damping * m.turn : 0));
            }
        }
    std::vector<JointBounds> bounds(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g)
        for (const auto& [place, sums] : of_element[g]) {
            if (sums.stiffness > bounds[g].stiffness) bounds[g].stiffness = sums.stiffness, bounds[g].element = place.second;
            bounds[g].drag = std::max(bounds[g].drag, sums.drag);
        }
    return bounds;
}

JointState joint_state(const JointSpec& table, const Joint& joint, const Slot<1>& a, const Slot<1>& a_next, const Slot<1>& b,
                       const Slot<1>& b_next) {
    using P = Pack<1>;
    const JointConstants<double> c = constants_of(joint);
    const auto element = [](const Slot<1>& at, const Slot<1>& next, double share, double before, const Vec3d& arm,
                            const Vec3d& axis) {
        return JoinedElement<P>{at.position, next.position, at.velocity, next.velocity,     at.director,
                                at.spin,     P(share),      P(before),   broadcast<1>(arm), broadcast<1>(axis)};
    };
    JointFigures<P> figures;
    with_joint(table, [&]<JointTurn Turn, bool Damped, bool Repels>() {
        JointLoad<P> other;
        joint_load<Turn, Damped, Repels, 1>(table.law, element(a, a_next, c.share_a, c.share_before_a, c.arm_a, c.axis_a),
                                            element(b, b_next, c.share_b, c.share_before_b, c.arm_b, c.axis_b),
                                            broadcast<1>(c.rest), P(c.rest_distance), other, &figures);
    });
    return {figures.energy[0], figures.gap[0]};
}

} // namespace skein
