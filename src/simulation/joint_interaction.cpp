#include "simulation/joint_interaction.hpp"

#include "joints/joint_limits.hpp"

#include <algorithm>
#include <map>

namespace skein {

std::vector<Figure> JointInteraction::figures(double lag) const {
    std::vector<std::size_t> rods;
    std::map<std::pair<int, std::int64_t>, std::size_t> place; // in rods, by group and index
    const auto local = rods_->local();
    for (std::size_t i = 0; i < local.size(); ++i) {
        const int assembly = plan_.groups[static_cast<std::size_t>(local[i].group)].assembly;
        if (assembly < 0 || plan_.assemblies[static_cast<std::size_t>(assembly)].joints.empty()) continue;
        place[{local[i].group, local[i].index}] = rods.size();
        rods.push_back(i);
    }
    std::vector<std::vector<Slot<1>>> state(rods.size());
    rods_->read(rods, Copy::synchronised, lag,
                [&](int, std::size_t i, const RodCopy& rod) { state[i].assign(rod.state.begin(), rod.state.end()); });
    std::vector<double> energies;
    double gap = 0;
    for (std::size_t a = 0; a < plan_.assemblies.size(); ++a)
        for (const Joint& joint : plan_.assemblies[a].joints) {
            const auto of_group = [&](int group) -> const RodGroup& { return groups_[static_cast<std::size_t>(group)]; };
            const std::int64_t first_rods = of_group(joint.first.group).rods_per_copy(),
                               second_rods = of_group(joint.second.group).rods_per_copy();
            for (std::int64_t copy = 0; copy < plan_.assemblies[a].copies; ++copy) {
                const auto at = place.find({joint.first.group, copy * first_rods + joint.first.rod});
                if (at == place.end()) continue;
                const auto& first = state[at->second];
                const auto& second = state[place.at({joint.second.group, copy * second_rods + joint.second.rod})];
                const auto k = static_cast<std::size_t>(joint.first.element), l = static_cast<std::size_t>(joint.second.element);
                const JointState now =
                    joint_state(plan_.joints[joint.table], joint, first[k], first[std::min(k + 1, first.size() - 1)], second[l],
                                second[std::min(l + 1, second.size() - 1)]);
                energies.push_back(now.energy);
                gap = std::max(gap, now.gap);
            }
        }
    return {{"joint_energy[J]", Figure::Of::sum, std::move(energies)}, {"joint_gap[m]", Figure::Of::largest, {gap}}};
}

} // namespace skein
