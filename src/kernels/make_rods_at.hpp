// From a plan to rods with their passes, at one width.
#pragma once

#include "joints/cluster_joints.hpp"
#include "kernels/make_pass.hpp"
#include "kernels/relaxing_joints.hpp"
#include "kernels/rod_tiles.hpp"
#include "skein/core/index.hpp"

#include <algorithm>

namespace skein {

template <int W, class Maker> TileProgram<W> make_program(const GroupProgram& of_plan, const Maker& maker) {
    TileProgram<W> program{.passes = {}, .names = {}, .before = of_plan.before()};
    const bool evaluated = of_plan.find<pass::StepImplicitly>() != nullptr,
               in_bed = of_plan.find<pass::StepInBed>() != nullptr;
    std::vector<EvaluatedPass<W>> loads;
    for (const PassSpec& pass : of_plan) {
        std::unique_ptr<TilePass<W>> made = PassKinds::make(pass, maker);
        const auto* load = pass.template get<pass::ApplyLoad>();
        const bool feels_fluid = pass.template get<pass::FeelFluid>() != nullptr; // slopes are known, as of joints
        const bool is_joined = pass.template get<pass::TakeJoinedLoads>() != nullptr;
        const bool has_slopes = !(load && load->load.ignores_motion()) && !feels_fluid && !is_joined;
        if (evaluated && pass.place > PassPlace::internal && pass.place < PassPlace::kick) {
            loads.push_back({std::move(made), has_slopes});
            continue;
        }
        if (in_bed && ((load && has_slopes) || feels_fluid)) {
            loads.push_back({std::move(made), has_slopes});
            continue;
        }
        if (auto* step = dynamic_cast<EvaluatesPasses<W>*>(made.get())) step->take(std::move(loads));
        if (dynamic_cast<StepsTogether<W>*>(made.get())) program.joined = program.passes.size();
        program.passes.push_back(std::move(made));
        program.names.push_back(pass.name);
    }
    program.last = static_cast<std::size_t>(std::count_if(
        of_plan.begin(), of_plan.end(), [](const PassSpec& pass) { return pass.place == PassPlace::balance; }));
    return program;
}

/// Mobilities in the kicks of all groups; `kicks` is where they are kept.
inline KickGains kick_gains(const Plan& plan, std::span<const RodGroup> groups, std::vector<KicksOfGroup>& kicks) {
    const Scheme scheme = scheme_of(plan.integrator);
    std::vector<KickedShares> shares;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        shares.push_back(kicked_shares(plan.groups[g].program));
        const auto* kick = plan.groups[g].program.find<pass::Kick>();
        kicks.push_back(kick ? kicks_of(*kick, plan.groups[g], groups[g], scheme, plan.dt) : KicksOfGroup());
    }
    const auto of = [&kicks](int group, std::size_t length) -> const KickConstants& {
        return nth(kicks, group)[length];
    };
    const auto gain = [of, shares](int group, int node, std::size_t length) {
        const KickedShares& kicked = nth(shares, group);
        const double own = nth(of(group, length).node, node).gain;
        return kicked.any() ? own / nth(kicked.of_nodes, node) : own;
    };
    return {.node = gain,
            .body = [of](int group, std::size_t length) { return of(group, length).element.front().gain; },
            .lengths = scheme.kicks.size()};
}

/// Gains of rods that no pass kicks: shared nodes come to one place by mass. `shares`: of the mass that steps feel, by
/// group; none: all of it.
inline KickGains gains_by_mass(std::span<const RodGroup> groups, const std::vector<KickedShares>& shares = {}) {
    return {.node =
                [groups, shares](int group, int node, std::size_t) {
                    const double mass = nth(nth(groups, group).node_mass, node);
                    const bool less = !shares.empty() && nth(shares, group).any();
                    return 1 / (less ? mass * nth(nth(shares, group).of_nodes, node) : mass);
                },
            .body =
                [groups](int group, std::size_t) {
                    const Vec3d& inertia = nth(groups, group).element.front().inertia;
                    return Vec3d{1 / inertia.x, 1 / inertia.y, 1 / inertia.z};
                }};
}

template <int W>
JointsOfAssemblies<W> make_joints(const Plan& plan, const JointLists& lists, std::span<const RodGroup> groups) {
    JointsOfAssemblies<W> joints;
    std::vector<KicksOfGroup> kicks;
    for (std::size_t a = 0; a < lists.of_assembly.size(); ++a) {
        const std::vector<Joint>& of_copy = lists.of_assembly[a];
        if (of_copy.empty()) {
            joints.push_back(nullptr);
            continue;
        }
        const Junctions junctions = junctions_of(lists.tables, of_copy, groups);
        if (plan.pseudo_time && !junctions.empty()) {
            joints.push_back(std::make_unique<RelaxingJoints<W>>(lists.tables, of_copy, groups, static_cast<int>(a),
                                                                 junctions, gains_by_mass(groups)));
            continue;
        }
        KickGains gains;
        if (!junctions.empty() && is_implicit(plan.integrator)) {
            std::vector<KickedShares> shares;
            for (std::size_t g = 0; g < groups.size(); ++g) shares.push_back(kicked_shares(plan.groups[g].program));
            gains = gains_by_mass(groups, shares);
        } else if (!junctions.empty()) {
            kicks.clear();
            gains = kick_gains(plan, groups, kicks);
        }
        joints.push_back(
            std::make_unique<JointsOfCluster<W>>(lists.tables, of_copy, groups, static_cast<int>(a), junctions, gains));
        if (is_implicit(plan.integrator)) joints.back()->use_ends();
    }
    return joints;
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
        const GroupProgram& program = plan.groups[g].program;
        if (program.find<pass::Walls>() || program.find<pass::SurfaceWalls>())
            parts.walls = std::make_shared<WallContactTiles<W>>(*around.walls, groups[g]);
        if (program.find<pass::StepInBed>()) parts.bed = std::make_shared<BedTiles<W>>();
        if (parts.bed && parts.walls) {
            parts.wall_tangents = std::make_shared<WallTangents<W>>();
            parts.wall_tangents->zone = around.meeting_zone;
        }
        const auto* by_steps = program.find<pass::StepImplicitly>();
        const bool audited = by_steps && by_steps->audited;
        if (audited || program.find<pass::AuditBalance>())
            parts.audit =
                audits.emplace_back(std::make_shared<EnergyBudget<W>>(groups[g], kicked_shares(program), audited));
        if (groups[g].spec().ends_move()) parts.moving = std::make_shared<MovingEnds>(groups[g]);
        parts.end_walls = std::make_shared<EndWalls<W>>(parts.moving);
        around.wall_contacts.push_back(parts.walls);
        around.beds.push_back(parts.bed);
        programs.push_back(make_program<W>(program, PassMaker<W>(parts)));
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
    if (around.joints) joints = make_joints<W>(plan, *around.joints, groups);
    return std::make_unique<RodTiles<W>>(groups, std::move(owned), tiling, std::move(programs), threads,
                                         std::move(audits), step_watch(plan), std::move(joints));
}

} // namespace skein
