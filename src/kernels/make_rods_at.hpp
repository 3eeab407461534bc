// From a plan to rods with their passes, at one width.
#pragma once

#include "joints/cluster_joints.hpp"
#include "kernels/make_pass.hpp"
#include "kernels/rod_tiles.hpp"
#include "skein/core/index.hpp"

namespace skein {

template <int W, class Maker> TileProgram<W> make_program(const GroupProgram& of_plan, const Maker& maker) {
    TileProgram<W> program{.passes = {}, .names = of_plan.names(), .before = of_plan.before.size()};
    for (std::size_t i = 0; i < of_plan.size(); ++i) program.passes.push_back(std::visit(maker, of_plan[i]));
    program.last = !of_plan.after.empty() && std::holds_alternative<pass::AuditBalance>(of_plan.after.back());
    return program;
}

/// Mobilities in the kicks of all groups; `kicks` is where they are kept.
inline KickGains kick_gains(const Plan& plan, std::span<const RodGroup> groups, std::vector<KicksOfGroup>& kicks) {
    const Scheme scheme = scheme_of(plan.integrator);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const GroupProgram& program = plan.groups[g].program;
        KicksOfGroup of_group;
        for (std::size_t i = 0; i < program.size() && of_group.empty(); ++i)
            if (const auto* kick = std::get_if<pass::Kick>(&program[i]))
                of_group = kicks_of(*kick, plan.groups[g], groups[g], scheme, plan.dt);
        kicks.push_back(std::move(of_group));
    }
    const auto of = [&kicks](int group, std::size_t length) -> const KickConstants& {
        return nth(kicks, group)[length];
    };
    return {.node = [of](int group, int node, std::size_t length) { return nth(of(group, length).node, node).gain; },
            .body = [of](int group, std::size_t length) { return of(group, length).element.front().gain; },
            .lengths = scheme.kicks.size()};
}

template <int W> std::unique_ptr<Rods> make_rods_at(const Plan& plan, std::span<const RodGroup> groups,
                                                    std::vector<LocalRod> owned, const Threads& threads,
                                                    Surroundings& around) {
    std::vector<TileProgram<W>> programs;
    std::vector<std::shared_ptr<EnergyBudget<W>>> audits;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        PassParts<W> parts{.plan = plan.groups[g],
                           .group = groups[g],
                           .scheme = scheme_of(plan.integrator),
                           .dt = plan.dt,
                           .around = around};
        if (plan.groups[g].walls) parts.walls = std::make_shared<WallContactTiles<W>>(*around.walls, groups[g]);
        if (plan.audit) parts.audit = audits.emplace_back(std::make_shared<EnergyBudget<W>>(groups[g]));
        if (groups[g].spec().ends_move()) parts.moving = std::make_shared<MovingEnds>(groups[g]);
        around.wall_contacts.push_back(parts.walls);
        programs.push_back(make_program<W>(plan.groups[g].program, PassMaker<W>(parts)));
    }
    std::vector<std::int64_t> counts(groups.size(), 0);
    for (const LocalRod& rod : owned) ++nth(counts, rod.group);
    const Tiling tiling = tiling_of(plan, counts, W);
    if (!tiling.along.empty())
        for (int family = 0; family < plan.families; ++family) {
            const AlongPassMaker<W> maker(plan, groups, family);
            programs.push_back(make_program<W>(maker.plan().program, maker));
        }
    JointsOfAssemblies<W> joints;
    std::vector<KicksOfGroup> kicks;
    for (std::size_t a = 0; a < plan.assemblies.size(); ++a) {
        const std::vector<Joint>& of_copy = plan.assemblies[a].joints;
        if (of_copy.empty()) {
            joints.push_back(nullptr);
            continue;
        }
        const Junctions junctions = junctions_of(plan.joints, of_copy, groups);
        KickGains gains;
        if (!junctions.empty()) {
            kicks.clear();
            gains = kick_gains(plan, groups, kicks);
        }
        joints.push_back(
            std::make_unique<JointsOfCluster<W>>(plan.joints, of_copy, groups, static_cast<int>(a), junctions, gains));
    }
    return std::make_unique<RodTiles<W>>(groups, std::move(owned), tiling, std::move(programs), threads,
                                         std::move(audits), step_watch(plan), std::move(joints));
}

} // namespace skein
