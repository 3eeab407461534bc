#include "physics/fluid/shared_nodes.hpp"

#include "joints/joint_limits.hpp"
#include "joints/junction.hpp"
#include "skein/core/index.hpp"

#include <cstdint>
#include <map>
#include <utility>

namespace skein {

namespace {

using PlacesOfRods = std::map<std::pair<int, std::int64_t>, std::size_t>; ///< in local(), by group and index

/// Mass that kicks of a hub's member feel, kg.
double kicked_mass(const Hub::Member& m, const InteractionParts& parts, const FluidPlan& plan) {
    return nth(nth(plan.rods, m.group).inertia->of_nodes, m.node).effective *
           nth(nth(parts.groups, m.group).node_mass, m.node);
}

SharedNode shared_node(const Hub& hub, std::int64_t copy, const PlacesOfRods& place, const InteractionParts& parts,
                       const FluidPlan& plan) {
    SharedNode node;
    double sum = 0;
    for (const Hub::Member& m : hub.members) {
        const std::int64_t index = copy * nth(parts.groups, m.group).rods_per_copy() + m.rod;
        node.slots.push_back(parts.around.fluid->first(place.at({m.group, index})) + to_index(m.node));
        node.shares.push_back(hub.held ? (node.shares.empty() ? 1.0 : 0.0) : kicked_mass(m, parts, plan));
        sum += node.shares.back();
    }
    for (double& share : node.shares) share /= sum;
    return node;
}

/// Asks the memory of a joint that may tear. Memory of joints stands last in that of the first rod of each.
std::function<bool(const Rods&)> tearing_of(const JointLists& all, const std::vector<Joint>& joints, std::size_t joint,
                                            std::int64_t copy, const PlacesOfRods& place,
                                            const InteractionParts& parts) {
    const JointEnd& side = joints[joint].first;
    const std::size_t rod = place.at({side.group, copy * nth(parts.groups, side.group).rods_per_copy() + side.rod});
    const std::size_t of_joints = nth(joint_memory_of_groups(all.tables, joints, parts.groups.size()), side.group);
    const JointNumbers own = numbers_of_joint(all.tables, joints, joint);
    return [=](const Rods& rods) {
        const std::vector<double> memory = rods.memory(rod);
        return has_ended(std::span(memory).last(of_joints).subspan(own.before, own.count));
    };
}

} // namespace

std::vector<SharedNode> shared_nodes(const InteractionParts& parts, const FluidPlan& plan) {
    std::vector<SharedNode> nodes;
    if (!parts.around.joints) return nodes;
    const auto local = parts.rods.local();
    PlacesOfRods place;
    for (std::size_t i = 0; i < local.size(); ++i) place[{local[i].group, local[i].index}] = i;
    for (const std::vector<Joint>& joints : parts.around.joints->of_assembly)
        for (const Hub& hub : junctions_of(parts.around.joints->tables, joints, parts.groups).hubs) {
            const Hub::Member& first = hub.members.front();
            const RodGroup& group = nth(parts.groups, first.group);
            for (std::int64_t copy = 0; copy < group.count() / group.rods_per_copy(); ++copy)
                if (place.contains({first.group, copy * group.rods_per_copy() + first.rod})) {
                    nodes.push_back(shared_node(hub, copy, place, parts, plan));
                    if (hub.joint != no_joint)
                        nodes.back().is_torn = tearing_of(*parts.around.joints, joints, hub.joint, copy, place, parts);
                }
        }
    return nodes;
}

} // namespace skein
