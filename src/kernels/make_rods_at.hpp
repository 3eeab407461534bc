// From a plan to rods with their passes, at one width.
#pragma once

#include "joints/cluster_joints.hpp"
#include "kernels/make_pass.hpp"
#include "rod/rod_tiles.hpp"

namespace skein {

template <int W, class Maker> TileProgram<W> make_program(const GroupProgram& of_plan, const Maker& maker) {
    TileProgram<W> program{.passes = {}, .names = of_plan.names(), .before = of_plan.before.size()};
    for (std::size_t i = 0; i < of_plan.size(); ++i) program.passes.push_back(std::visit(maker, of_plan[i]));
    return program;
}

template <int W> std::unique_ptr<Rods> make_rods_at(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned,
                                                    const Threads& threads, Surroundings& around) {
    std::vector<TileProgram<W>> programs;
    std::vector<std::shared_ptr<EnergyBudget<W>>> audits;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        PassParts<W> parts{
            .plan = plan.groups[g], .group = groups[g], .scheme = scheme_of(plan.integrator), .dt = plan.dt, .around = around};
        if (plan.groups[g].walls) parts.walls = std::make_shared<WallContactTiles<W>>(*around.walls, groups[g]);
        if (plan.audit) parts.audit = audits.emplace_back(std::make_shared<EnergyBudget<W>>(groups[g]));
        if (groups[g].spec().ends_move()) parts.moving = std::make_shared<MovingEnds>(groups[g]);
        around.wall_contacts.push_back(parts.walls);
        programs.push_back(make_program<W>(plan.groups[g].program, PassMaker<W>(parts)));
    }
    std::vector<std::int64_t> counts(groups.size(), 0);
    for (const LocalRod& rod : owned) ++counts[static_cast<std::size_t>(rod.group)];
    const Tiling tiling = tiling_of(plan, counts, W);
    if (!tiling.along.empty())
        for (int family = 0; family < plan.families; ++family) {
            const AlongPassMaker<W> maker(plan, groups, family);
            programs.push_back(make_program<W>(maker.plan().program, maker));
        }
    JointsOfAssemblies<W> joints;
    for (std::size_t a = 0; a < plan.assemblies.size(); ++a) {
        const std::vector<Joint>& of_copy = plan.assemblies[a].joints;
        joints.push_back(of_copy.empty() ? nullptr
                                         : std::make_unique<JointsOfCluster<W>>(plan.joints, of_copy, groups, static_cast<int>(a)));
    }
    return std::make_unique<RodTiles<W>>(groups, std::move(owned), tiling, std::move(programs), threads, std::move(audits),
                                         step_watch(plan), std::move(joints));
}

} // namespace skein
