// From a plan to rods with their passes, at one width.
#pragma once

#include "joints/cluster_joints.hpp"
#include "kernels/make_pass.hpp"
#include "kernels/relaxing_joints.hpp"
#include "kernels/rod_tiles.hpp"
#include "plan/group_plan.hpp"
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
        const bool is_touched = pass.template get<pass::TakeLoads>() || pass.template get<pass::TakeSurfaceLoads>();
        const bool has_slopes = !(load && load->load.ignores_motion()) && !feels_fluid && !is_joined && !is_touched;
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

/// Mobilities of rods, by group and, where rods have sizes of their own, by number.
template <class Of> class OfRods {
public:
    /// `make(group plan, group)`: of rods that have the constants of a group.
    template <class Make> OfRods(const Plan& plan, std::span<const RodGroup> groups, Make make) {
        for (std::size_t g = 0; g < groups.size(); ++g) {
            auto& [heterogeneous, all] = of_group_.emplace_back();
            heterogeneous = groups[g].heterogeneous();
            if (!heterogeneous) all.push_back(make(plan.groups[g], groups[g]));
            for (std::int64_t i = 0; heterogeneous && groups[g].assembly() && i < groups[g].rods_per_copy(); ++i)
                all.push_back(make(plan_of_rod(plan, groups[g].kind(i)), groups[g].kind(i)));
        }
    }
    const Of& operator()(int group, std::int64_t rod) const {
        const auto& [heterogeneous, all] = nth(of_group_, group);
        return heterogeneous ? nth(all, rod) : all.front();
    }

private:
    struct OfGroup {
        bool heterogeneous;
        std::vector<Of> all;
    };
    std::vector<OfGroup> of_group_;
};

/// Shares of the mass that steps feel in a fluid.
inline OfRods<KickedShares> shares_of_rods(const Plan& plan, std::span<const RodGroup> groups) {
    return {plan, groups, [](const GroupPlan& of, const RodGroup&) { return kicked_shares(of.program); }};
}

/// Mobilities in the kicks of all rods.
inline KickGains kick_gains(const Plan& plan, std::span<const RodGroup> groups) {
    const Scheme scheme = scheme_of(plan.integrator);
    const auto kicks =
        std::make_shared<const OfRods<KicksOfGroup>>(plan, groups, [&](const GroupPlan& of, const RodGroup& group) {
            const auto* kick = of.program.find<pass::Kick>();
            return kick ? kicks_of(*kick, of, group, scheme, plan.dt) : KicksOfGroup();
        });
    const auto shares = std::make_shared<const OfRods<KickedShares>>(shares_of_rods(plan, groups));
    const auto gain = [kicks, shares](int group, std::int64_t rod, int node, std::size_t length) {
        const KickedShares& kicked = (*shares)(group, rod);
        const double own = nth((*kicks)(group, rod)[length].node, node).gain;
        return kicked.any() ? own / nth(kicked.of_nodes, node) : own;
    };
    return {.node = gain,
            .body = [kicks](int group, std::size_t length) { return (*kicks)(group, 0)[length].element.front().gain; },
            .lengths = scheme.kicks.size()};
}

/// Gains of rods that no pass kicks: shared nodes come to one place by mass. `shares`: of the mass that steps feel;
/// null: all of it.
inline KickGains gains_by_mass(std::span<const RodGroup> groups,
                               std::shared_ptr<const OfRods<KickedShares>> shares = nullptr) {
    return {.node =
                [groups, shares](int group, std::int64_t rod, int node, std::size_t) {
                    const double mass = nth(nth(groups, group).kind(rod).node_mass, node);
                    const bool less = shares && (*shares)(group, rod).any();
                    return 1 / (less ? mass * nth((*shares)(group, rod).of_nodes, node) : mass);
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
        if (!junctions.empty() && is_implicit(plan.integrator))
            gains = gains_by_mass(groups, std::make_shared<const OfRods<KickedShares>>(shares_of_rods(plan, groups)));
        else if (!junctions.empty()) gains = kick_gains(plan, groups);
        joints.push_back(
            std::make_unique<JointsOfCluster<W>>(lists.tables, of_copy, groups, static_cast<int>(a), junctions, gains));
        if (is_implicit(plan.integrator)) joints.back()->use_ends();
    }
    return joints;
}

/// Programs of tiles, and the parts that they share with interactions.
template <int W> struct MadePrograms {
    std::vector<TileProgram<W>> programs;
    std::vector<std::shared_ptr<EnergyBudget<W>>> audits; ///< by program, or none at all
    Surroundings& around;

    /// Adds the program of rods that have the constants of `group`.
    void add(const Plan& plan, const GroupPlan& of, const RodGroup& group) {
        PassParts<W> parts{
            .plan = of, .group = group, .scheme = scheme_of(plan.integrator), .dt = plan.dt, .around = around};
        const GroupProgram& program = of.program;
        if (program.find<pass::Walls>() || program.find<pass::SurfaceWalls>())
            parts.walls = std::make_shared<WallContactTiles<W>>(*around.walls, group);
        if (program.find<pass::StepInBed>()) parts.bed = std::make_shared<BedTiles<W>>();
        if (parts.bed && parts.walls) {
            parts.wall_tangents = std::make_shared<WallTangents<W>>();
            parts.wall_tangents->zone = around.meeting_zone;
        }
        const auto* by_steps = program.find<pass::StepImplicitly>();
        const bool audited = by_steps && by_steps->audited;
        if (audited || program.find<pass::AuditBalance>())
            parts.audit = std::make_shared<EnergyBudget<W>>(group, kicked_shares(program), audited);
        if (group.spec().ends_move()) parts.moving = std::make_shared<MovingEnds>(group);
        parts.end_walls = std::make_shared<EndWalls<W>>(parts.moving);
        add(make_program<W>(program, PassMaker<W>(parts)), parts.walls, parts.bed, parts.audit);
    }
    void add(TileProgram<W> program, std::shared_ptr<WallContacts> walls, std::shared_ptr<BedFigures> bed,
             std::shared_ptr<EnergyBudget<W>> audit) {
        around.wall_contacts.push_back(std::move(walls));
        around.beds.push_back(std::move(bed));
        if (audit || !audits.empty()) audits.resize(programs.size());
        if (audit || !audits.empty()) audits.push_back(std::move(audit));
        programs.push_back(std::move(program));
    }
};

template <int W> std::unique_ptr<Rods> make_rods_at(const Plan& plan, std::span<const RodGroup> groups,
                                                    std::vector<LocalRod> owned, const Threads& threads,
                                                    Surroundings& around) {
    MadePrograms<W> made{.programs = {}, .audits = {}, .around = around};
    for (std::size_t g = 0; g < groups.size(); ++g) made.add(plan, plan.groups[g], groups[g]);
    std::vector<std::int64_t> counts(groups.size(), 0);
    for (const LocalRod& rod : owned) ++nth(counts, rod.group);
    const Tiling tiling = tiling_of(plan, counts, W);
    if (!tiling.along.empty())
        for (int family = 0; family < plan.families; ++family) {
            const AlongPassMaker<W> maker(plan, groups, family, around);
            made.add(make_program<W>(maker.plan().program, maker), maker.walls(), nullptr, maker.audit());
        }
    for (const LocalRod& rod : owned)
        if (nth(plan.groups, rod.group).own_sizes == OwnSizes::apart) {
            const RodGroup& own = nth(groups, rod.group).kind(rod.index);
            made.add(plan, plan_of_rod(plan, own), own);
        }
    JointsOfAssemblies<W> joints;
    if (around.joints) joints = make_joints<W>(plan, *around.joints, groups);
    return std::make_unique<RodTiles<W>>(groups, std::move(owned), tiling, std::move(made.programs), threads,
                                         std::move(made.audits), step_watch(plan), std::move(joints));
}

} // namespace skein
