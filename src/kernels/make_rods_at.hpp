// From a plan to rods with their passes, at one width: the one place where run-time choices of the scene become template arguments.
#pragma once

#include "contact/wall_pass.hpp"
#include "kernels/surroundings.hpp"
#include "loads/laplacian_filter.hpp"
#include "loads/load_pass.hpp"
#include "rod/audit.hpp"
#include "rod/elastic.hpp"
#include "rod/hold.hpp"
#include "rod/kick.hpp"
#include "rod/rigid.hpp"
#include "rod/rod_tiles.hpp"
#include "rod/top.hpp"

namespace skein {

template <int W> std::unique_ptr<TilePass<W>> make_elastic(const RodGroup& group, const std::shared_ptr<MovingEnds>& moving) {
    if (is_rigid(group)) return std::make_unique<RigidRestPass<W>>();
    if (group.law() == Law::elastica) return std::make_unique<ElasticaPass<W>>(ends_of(group));
    return with_energy_law(group.law(), [&]<class L>(L) -> std::unique_ptr<TilePass<W>> {
        return std::make_unique<ElasticPass<L, W>>(ends_of(group), moving);
    });
}

inline KicksOfGroup kicks_of(const GroupPlan& plan, const RodGroup& group, Scheme scheme, double dt) {
    KicksOfGroup kicks;
    DampingRates rates = damping_rates(group, plan.damping);
    if (is_rigid(group)) rates = rigid_rates(std::move(rates));
    for (const double share : scheme.kicks) kicks.emplace_back(group, rates, share * dt, plan.damping_scheme);
    return kicks;
}

/// Calls make.operator()<Kind>() with the kind of kick that a law with an energy has.
template <class F> auto with_kick(KickKind kind, F&& make) {
    switch (kind) {
    case KickKind::undamped:
        return make.template operator()<KickKind::undamped>();
    case KickKind::constant_rates:
        return make.template operator()<KickKind::constant_rates>();
    case KickKind::stretched_rates:
        return make.template operator()<KickKind::stretched_rates>();
    case KickKind::stretched_exponential:
        return make.template operator()<KickKind::stretched_exponential>();
    case KickKind::stretched_after:
    case KickKind::elastica:
        break;
    }
    return make.template operator()<KickKind::stretched_after>();
}

template <int W> std::unique_ptr<TilePass<W>> make_kick(const GroupPlan& plan, const RodGroup& group, Scheme scheme, double dt) {
    KicksOfGroup kicks = kicks_of(plan, group, scheme, dt);
    if (is_rigid(group)) return std::make_unique<RigidKickPass<W>>(std::move(kicks));
    if (plan.kick == KickKind::elastica) return std::make_unique<KickPass<KickKind::elastica, W>>(std::move(kicks));
    return with_kick(plan.kick, [&]<KickKind Kind>() -> std::unique_ptr<TilePass<W>> {
        return std::make_unique<KickPass<Kind, W>>(std::move(kicks));
    });
}

template <int W> std::unique_ptr<TilePass<W>> make_audit_inner(const RodGroup& group, const std::shared_ptr<AuditBook<W>>& book,
                                                               const std::shared_ptr<MovingEnds>& moving) {
    return with_energy_law(group.law(), [&]<class L>(L) -> std::unique_ptr<TilePass<W>> {
        return std::make_unique<AuditInnerPass<L, W>>(book, ends_of(group), moving);
    });
}

/// The step of one group: drift, forces, kick (theory.md (20)). `audit`: its book, or null.
template <int W> TileProgram<W> make_program(const GroupPlan& plan, const RodGroup& group, Scheme scheme, double dt,
                                             const std::shared_ptr<AuditBook<W>>& audit = nullptr, const Surroundings& around = {},
                                             const std::shared_ptr<WallBook<W>>& walls = nullptr) {
    TileProgram<W> program;
    if (is_rigid(group)) program.push_back(std::make_unique<RigidDriftPass<W>>());
    else with_top(group, [&]<class Top>(Top) { program.push_back(std::make_unique<DriftPass<Top, W>>()); });
    if (group.closed()) program.push_back(std::make_unique<CloseRingPass<W>>());
    const auto moving = group.spec().ends_move() ? std::make_shared<MovingEnds>(group) : nullptr;
    if (moving && audit) program.push_back(std::make_unique<AuditEndsPass<W>>(audit));
    if (moving) program.push_back(std::make_unique<MoveEndsPass<W>>(moving));
    program.push_back(std::make_unique<OrthonormalisePass<W>>());
    if (around.others) program.push_back(std::make_unique<ShowPass<W>>(around.others));
    program.push_back(make_elastic<W>(group, moving));
    if (audit) program.push_back(make_audit_inner<W>(group, audit, moving));
    for (const Load& load : plan.loads)
        if (!load.feels_all()) program.push_back(make_pass<W>(load, group));
    if (walls) program.push_back(std::make_unique<WallPass<W>>(around.walls, group, walls));
    if (around.others) program.push_back(std::make_unique<FeelPass<W>>(around.others));
    for (const Load& load : plan.loads)
        if (load.feels_all()) program.push_back(make_pass<W>(load, group));
    if (group.closed()) program.push_back(std::make_unique<FoldRingPass<W>>());
    if (audit) program.push_back(std::make_unique<AuditLoadsPass<W>>(audit));
    const bool filtered = std::any_of(plan.damping.begin(), plan.damping.end(), is_filter);
    program.push_back(make_kick<W>(plan, group, scheme, filtered ? 0.5 * dt : dt));
    for (const Damping& d : plan.damping)
        if (is_filter(d)) program.push_back(std::make_unique<LaplacianFilterPass<W>>(group, d.order, d.rate, dt));
    if (filtered) program.push_back(make_kick<W>(plan, group, scheme, 0.5 * dt));
    if (group.spec().hold.any()) program.push_back(std::make_unique<HoldPass<W>>());
    if (audit) program.push_back(std::make_unique<AuditBalancePass<W>>(audit, moving != nullptr));
    return program;
}

/// The same along the rod, of a family of groups that differ in constants alone.
template <int W> TileProgram<W> make_program_along(const Plan& plan, std::span<const RodGroup> groups, int family) {
    const Scheme scheme = scheme_of(plan.integrator);
    std::map<int, KicksOfGroup> kicks;
    const RodGroup* any = nullptr;
    Ends ends;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (plan.groups[g].family != family) continue;
        any = &groups[g];
        kicks.emplace(groups[g].id(), kicks_of(plan.groups[g], groups[g], scheme, plan.dt));
        ends.start_wall |= ends_of(groups[g]).start_wall;
    }
    const GroupPlan& one = plan.groups[static_cast<std::size_t>(any->id())];
    using Map = Along<W>;
    TileProgram<W> program;
    with_top(*any, [&]<class Top>(Top) { program.push_back(std::make_unique<DriftPass<Top, W, Map>>()); });
    program.push_back(std::make_unique<OrthonormalisePass<W, Map>>());
    with_energy_law(any->law(), [&]<class L>(L) { program.push_back(std::make_unique<ElasticPass<L, W, Map>>(ends)); });
    for (const bool last : {false, true}) // planes that rub answer all others
        for (const Load& load : one.loads)
            if (load.feels_all() == last) program.push_back(make_pass<W, Map>(load, *any));
    std::function<KicksOfGroup(const RodGroup&)> of_rod;
    if (any->sized())
        of_rod = [damped = one, scheme, dt = plan.dt](const RodGroup& rod) { return kicks_of(damped, rod, scheme, dt); };
    with_kick(one.kick,
              [&]<KickKind Kind> { program.push_back(std::make_unique<KickAlongPass<Kind, W>>(std::move(kicks), of_rod)); });
    return program;
}

template <int W> std::unique_ptr<Rods> make_rods_at(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned,
                                                    const Threads& threads, Surroundings& around) {
    std::vector<TileProgram<W>> programs;
    std::vector<std::shared_ptr<AuditBook<W>>> audits;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const auto audit = plan.audit ? std::make_shared<AuditBook<W>>(groups[g]) : nullptr;
        const auto walls = plan.groups[g].walls ? std::make_shared<WallBook<W>>(*around.walls, groups[g]) : nullptr;
        around.accounts.push_back(walls);
        programs.push_back(make_program<W>(plan.groups[g], groups[g], scheme_of(plan.integrator), plan.dt, audit, around, walls));
        if (audit) audits.push_back(audit);
    }
    std::vector<std::int64_t> counts(groups.size(), 0);
    for (const LocalRod& rod : owned) ++counts[static_cast<std::size_t>(rod.group)];
    const Tiling tiling = tiling_of(plan, counts, W);
    if (!tiling.along.empty())
        for (int family = 0; family < plan.families; ++family) programs.push_back(make_program_along<W>(plan, groups, family));
    return std::make_unique<RodTiles<W>>(groups, std::move(owned), tiling, std::move(programs), threads, std::move(audits),
                                         step_watch(plan));
}

} // namespace skein
