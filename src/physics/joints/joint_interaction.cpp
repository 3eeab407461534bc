#include "physics/joints/joint_interaction.hpp"

#include "joints/joint_limits.hpp"
#include "physics/joints/joint_plan.hpp"
#include "skein/core/index.hpp"
#include "tiles/clusters.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <tuple>
#include <utility>

namespace skein {

namespace {

/// Memory of joints, which stands last in that of the rod that each joint names first, in the order of joints.
class JointMemories {
public:
    /// `rods`: places in all.local().
    JointMemories(const JointPlan& plan, std::span<const RodGroup> groups, const Rods& all,
                  std::span<const std::size_t> rods) {
        std::map<int, std::vector<std::size_t>> of_groups; // by assembly and group
        for (const std::size_t i : rods) {
            const LocalRod& rod = all.local()[i];
            const int assembly = nth(groups, rod.group).assembly()->number;
            auto& of_assembly = of_groups[assembly];
            if (of_assembly.empty())
                of_assembly =
                    joint_memory_of_groups(plan.joints->tables, nth(plan.joints->of_assembly, assembly), groups.size());
            const std::size_t numbers = nth(of_assembly, rod.group);
            numbers_.push_back(numbers > 0 ? all.memory(i) : std::vector<double>());
            next_.push_back(numbers_.back().size() - numbers);
        }
    }
    /// The next one of a rod, by its place in `rods`, of a joint of this table.
    std::span<const double> next(std::size_t rod, const JointSpec& table) {
        const std::size_t count = memory_numbers(table);
        return std::span(numbers_[rod]).subspan(std::exchange(next_[rod], next_[rod] + count), count);
    }

private:
    std::vector<std::vector<double>> numbers_;
    std::vector<std::size_t> next_;
};

using PlacesOfRods = std::map<std::pair<int, std::int64_t>, std::size_t>;        ///< by group and index
using TornJoints = std::set<std::tuple<std::size_t, std::size_t, std::int64_t>>; ///< assembly, number and copy

/// Energies of half cells that meet.
void add_stars(const JointPlan& plan, std::span<const RodGroup> groups, const PlacesOfRods& place,
               std::span<const std::vector<Slot<1>>> state, const TornJoints& torn, JointsNow& found) {
    for (std::size_t a = 0; a < plan.assemblies.size(); ++a) {
        const AssemblyPlan& assembly = plan.assemblies[a];
        const Junctions junctions = junctions_of(plan.joints->tables, plan.joints->of_assembly[a], groups);
        for (const Star& star : junctions.stars)
            for (std::int64_t copy = 0; copy < assembly.copies; ++copy) {
                const auto rod = [&](int group, std::int64_t number) {
                    return place.find({group, copy * nth(groups, group).rods_per_copy() + number});
                };
                if (rod(star.members[0].group, star.members[0].rod) == place.end() ||
                    torn.contains({a, star.joint, copy}))
                    continue;
                found.energies.push_back(star_energy(star, [&](int group, std::int64_t number, int k) {
                    const auto& slots = state[rod(group, number)->second];
                    const auto at = static_cast<std::size_t>(k);
                    return std::pair(slots[at], slots[std::min(at + 1, slots.size() - 1)]);
                }));
            }
    }
}

} // namespace

JointsNow joints_now(const JointPlan& plan, std::span<const RodGroup> groups, const Rods& all, const Sample& at_time) {
    std::vector<std::size_t> rods;
    PlacesOfRods place;
    const auto local = all.local();
    for (std::size_t i = 0; i < local.size(); ++i) {
        const auto& assembly = nth(groups, local[i].group).assembly();
        if (!assembly || nth(plan.joints->of_assembly, assembly->number).empty()) continue;
        place[{local[i].group, local[i].index}] = rods.size();
        rods.push_back(i);
    }
    std::vector<std::vector<Slot<1>>> state(rods.size());
    all.read(rods, Copy::synchronised, at_time.lag,
             [&](int, std::size_t i, const RodCopy& rod) { state[i].assign(rod.state.begin(), rod.state.end()); });
    JointMemories memory(plan, groups, all, rods);
    JointsNow found;
    TornJoints torn;
    found.forces.assign(plan.joints->tables.size(), 0);
    found.gaps = found.forces;
    for (std::size_t a = 0; a < plan.assemblies.size(); ++a)
        for (std::size_t j = 0; j < plan.joints->of_assembly[a].size(); ++j) {
            const Joint& joint = plan.joints->of_assembly[a][j];
            const auto of_group = [&](int group) -> const RodGroup& { return nth(groups, group); };
            const bool to_world = joint.second.of_world();
            const std::int64_t first_rods = of_group(joint.first.group).rods_per_copy(),
                               second_rods = to_world ? 0 : of_group(joint.second.group).rods_per_copy();
            for (std::int64_t copy = 0; copy < plan.assemblies[a].copies; ++copy) {
                const auto at = place.find({joint.first.group, copy * first_rods + joint.first.rod});
                if (at == place.end()) continue;
                const auto& first = state[at->second];
                const std::vector<Slot<1>> world =
                    to_world ? std::vector{world_of(of_group(joint.first.group), at->first.second)}
                             : std::vector<Slot<1>>();
                const auto& second =
                    to_world ? world : state[place.at({joint.second.group, copy * second_rods + joint.second.rod})];
                const auto k = static_cast<std::size_t>(joint.first.element),
                           l = static_cast<std::size_t>(joint.second.element);
                const JointSpec& table = plan.joints->tables[joint.table];
                const std::span<const double> of_joint = memory.next(at->second, table);
                if (tears(table) && has_ended(of_joint)) torn.insert({a, j, copy});
                const JointState now =
                    joint_state(table, joint, first[k], first[std::min(k + 1, first.size() - 1)], second[l],
                                second[std::min(l + 1, second.size() - 1)], at_time.time, at->first.second, of_joint);
                found.motor_works.push_back(now.motor_work);
                found.losses.push_back(-now.lost_work);
                found.energies.push_back(now.energy);
                found.gap = std::max(found.gap, now.gap);
                found.forces[joint.table] = std::max(found.forces[joint.table], now.force);
                found.gaps[joint.table] = std::max(found.gaps[joint.table], now.gap);
            }
        }
    add_stars(plan, groups, place, state, torn, found);
    return found;
}

std::vector<Figure> JointInteraction::figures(const Sample& sample) const {
    JointsNow now = joints_now(plan_, groups_, *rods_, sample);
    std::vector<Figure> figures = {{"joint_energy[J]", Figure::Of::sum, std::move(now.energies)},
                                   {"joint_gap[m]", Figure::Of::largest, {now.gap}}};
    if (plan_.has_axes()) {
        for (auto& [name, terms] :
             {std::pair{"joint_motor_work[J]", &now.motor_works}, {"joint_loss[J]", &now.losses}}) {
            figures.push_back({name, Figure::Of::sum, std::move(*terms)});
            figures.back().of_steps = true;
        }
    }
    for (std::size_t t = 0; t < plan_.joints->tables.size(); ++t) {
        const std::string& name = plan_.joints->tables[t].name;
        if (name.empty()) continue;
        figures.push_back({name + "_force[N]", Figure::Of::largest, {now.forces[t]}});
        figures.push_back({name + "_gap[m]", Figure::Of::largest, {now.gaps[t]}});
    }
    return figures;
}

} // namespace skein
