// make_rods at one SIMD width; instantiated once per width, each in a file of its own to keep builds parallel.
#pragma once

#include "loads/laplacian_filter.hpp"
#include "loads/load_pass.hpp"
#include "rod/audit.hpp"
#include "rod/elastic.hpp"
#include "rod/hold.hpp"
#include "rod/kick.hpp"
#include "rod/rod_tiles.hpp"
#include "rod/top.hpp"
#include "simulation/make_rods.hpp"

namespace skein {

template <int W> std::unique_ptr<TilePass<W>> make_elastic(const RodGroup& group, const std::shared_ptr<MovingEnds>& moving) {
    if (group.law() == Law::elastica) return std::make_unique<ElasticaPass<W>>(ends_of(group));
    return with_energy_law(group.law(), [&]<class L>(L) -> std::unique_ptr<TilePass<W>> { return std::make_unique<ElasticPass<L, W>>(ends_of(group), moving); });
}

template <int W> std::unique_ptr<TilePass<W>> make_kick(const GroupPlan& plan, const RodGroup& group, Scheme scheme, double dt) {
    std::vector<KickConstants> constants;
    for (const double share : scheme.kicks) constants.emplace_back(group, damping_rates(group, plan.damping), share * dt, plan.damping_scheme);
    const auto make = [&]<KickKind Kind> { return std::make_unique<KickPass<Kind, W>>(std::move(constants)); };
    switch (plan.kick) {
    case KickKind::undamped: return make.template operator()<KickKind::undamped>();
    case KickKind::constant_rates: return make.template operator()<KickKind::constant_rates>();
    case KickKind::stretched_rates: return make.template operator()<KickKind::stretched_rates>();
    case KickKind::stretched_exponential: return make.template operator()<KickKind::stretched_exponential>();
    case KickKind::stretched_after: return make.template operator()<KickKind::stretched_after>();
    case KickKind::elastica: break;
    }
    return make.template operator()<KickKind::elastica>();
}

template <int W>
std::unique_ptr<TilePass<W>> make_audit_inner(const RodGroup& group, const std::shared_ptr<AuditBook<W>>& book, const std::shared_ptr<MovingEnds>& moving) {
    return with_energy_law(group.law(), [&]<class L>(L) -> std::unique_ptr<TilePass<W>> { return std::make_unique<AuditInnerPass<L, W>>(book, ends_of(group), moving); });
}

/// The step of one group: drift, forces, kick (theory.md (20)). `audit`: its book, or null.
template <int W>
TileProgram<W> make_program(const GroupPlan& plan, const RodGroup& group, Scheme scheme, double dt, const std::shared_ptr<AuditBook<W>>& audit = nullptr) {
    TileProgram<W> program;
    with_top(group, [&]<class Top>(Top) { program.push_back(std::make_unique<DriftPass<Top, W>>()); });
    if (group.closed()) program.push_back(std::make_unique<CloseRingPass<W>>());
    const auto moving = group.spec().ends_move() ? std::make_shared<MovingEnds>(group) : nullptr;
    if (moving && audit) program.push_back(std::make_unique<AuditEndsPass<W>>(audit));
    if (moving) program.push_back(std::make_unique<MoveEndsPass<W>>(moving));
    program.push_back(std::make_unique<OrthonormalisePass<W>>());
    program.push_back(make_elastic<W>(group, moving));
    if (audit) program.push_back(make_audit_inner<W>(group, audit, moving));
    for (const Load& load : plan.loads) program.push_back(make_pass<W>(load, group));
    if (group.closed()) program.push_back(std::make_unique<FoldRingPass<W>>());
    if (audit) program.push_back(std::make_unique<AuditLoadsPass<W>>(audit));
    program.push_back(make_kick<W>(plan, group, scheme, dt));
    for (const Damping& d : plan.damping)
        if (d.kind == DampingKind::laplacian) program.push_back(std::make_unique<LaplacianFilterPass<W>>(d.order));
    if (group.spec().hold.any()) program.push_back(std::make_unique<HoldPass<W>>());
    if (audit) program.push_back(std::make_unique<AuditBalancePass<W>>(audit, moving != nullptr));
    return program;
}

template <int W>
std::unique_ptr<Rods> make_rods_at(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned, const Threads& threads) {
    std::vector<TileProgram<W>> programs;
    std::vector<std::shared_ptr<AuditBook<W>>> audits;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const auto audit = plan.audit ? std::make_shared<AuditBook<W>>(groups[g]) : nullptr;
        programs.push_back(make_program<W>(plan.groups[g], groups[g], scheme_of(plan.integrator), plan.dt, audit));
        if (audit) audits.push_back(audit);
    }
    return std::make_unique<RodTiles<W>>(
        groups, std::move(owned), std::move(programs), threads, std::move(audits),
        StepWatch{.dt = plan.dt, .stability = scheme_of(plan.integrator).stability, .stops = !plan.force_dt});
}

#define SKEIN_MAKE_RODS_AT(W) \
    template std::unique_ptr<Rods> make_rods_at<W>(const Plan&, std::span<const RodGroup>, std::vector<LocalRod>, const Threads&)
#define SKEIN_MAKE_PROGRAM(W) \
    template TileProgram<W> make_program<W>(const GroupPlan&, const RodGroup&, Scheme, double, const std::shared_ptr<AuditBook<W>>&)
extern SKEIN_MAKE_PROGRAM(1);
extern SKEIN_MAKE_PROGRAM(2);
extern SKEIN_MAKE_PROGRAM(4);
extern SKEIN_MAKE_PROGRAM(8);
extern SKEIN_MAKE_RODS_AT(1);
extern SKEIN_MAKE_RODS_AT(2);
extern SKEIN_MAKE_RODS_AT(4);
extern SKEIN_MAKE_RODS_AT(8);

} // namespace skein
