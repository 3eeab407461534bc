#include "physics/fluid/shared_nodes.hpp"

#include "joints/joint_limits.hpp"
#include "joints/junction.hpp"
#include "skein/core/index.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>

namespace skein {

namespace {

using PlacesOfRods = std::map<std::pair<int, std::int64_t>, std::size_t>; ///< in local(), by group and index

/// Mass that kicks of a hub's member feel, kg.
double kicked_mass(const Hub::Member& m, const InteractionParts& parts, const FluidPlan& plan) {
    const RodGroup& group = nth(parts.groups, m.group);
    return nth(plan.kinds->of(group, m.rod).inertia->of_nodes, m.node).effective *
           nth(group.kind(m.rod).node_mass, m.node);
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
        if (hub.body) node.arms.push_back(m.arm);
    }
    for (double& share : node.shares) share /= sum;
    return node;
}

/// Memory of a joint that may tear. That of joints stands last in the memory of the first rod of each.
struct TearingMemory {
    int group;
    std::int64_t rod; ///< of the copy
    std::size_t from_end, count;

    bool is_torn(std::span<const double> of_rod) const { return has_ended(of_rod.last(from_end).first(count)); }
};

/// Shared nodes of the copies of an assembly on this rank.
void add_shared_nodes(const std::vector<Joint>& joints, const PlacesOfRods& place, const InteractionParts& parts,
                      const FluidPlan& plan, std::vector<SharedNode>& nodes) {
    const std::vector<JointSpec>& tables = parts.around.joints->tables;
    const std::vector<std::size_t> numbers = joint_memory_of_groups(tables, joints, parts.groups.size());
    for (const Hub& hub : junctions_of(tables, joints, parts.groups).hubs) {
        std::optional<TearingMemory> tearing;
        if (hub.joint != no_joint) {
            const JointEnd& side = joints[hub.joint].first;
            const JointNumbers own = numbers_of_joint(tables, joints, hub.joint);
            tearing = {side.group, side.rod, nth(numbers, side.group) - own.before, own.count};
        }
        const auto place_of = [&](int group, std::int64_t rod, std::int64_t copy) {
            return place.find({group, copy * nth(parts.groups, group).rods_per_copy() + rod});
        };
        const Hub::Member& first = hub.members.front();
        const RodGroup& group = nth(parts.groups, first.group);
        for (std::int64_t copy = 0; copy < group.count() / group.rods_per_copy(); ++copy) {
            if (place_of(first.group, first.rod, copy) == place.end()) continue;
            nodes.push_back(shared_node(hub, copy, place, parts, plan));
            if (!tearing) continue;
            nodes.back().is_torn = [memory = *tearing, rod = place_of(tearing->group, tearing->rod, copy)->second](
                                       const Rods& rods) { return memory.is_torn(rods.memory(rod)); };
        }
    }
}

} // namespace

std::vector<SharedNode> shared_nodes(const InteractionParts& parts, const FluidPlan& plan) {
    std::vector<SharedNode> nodes;
    if (!parts.around.joints) return nodes;
    const auto local = parts.rods.local();
    PlacesOfRods place;
    for (std::size_t i = 0; i < local.size(); ++i) place[{local[i].group, local[i].index}] = i;
    for (const std::vector<Joint>& joints : parts.around.joints->of_assembly)
        add_shared_nodes(joints, place, parts, plan, nodes);
    return nodes;
}

} // namespace skein
