// make_rods at one SIMD width; instantiated once per width, each in a file of its own to keep builds parallel.
#pragma once

#include "loads/laplacian_filter.hpp"
#include "loads/load_pass.hpp"
#include "rod/elastic.hpp"
#include "rod/kick.hpp"
#include "rod/rod_tiles.hpp"
#include "rod/top.hpp"
#include "simulation/make_rods.hpp"

namespace skein {

template <int W> std::unique_ptr<TilePass<W>> make_kick(const GroupPlan& plan, const RodGroup& group, double dt) {
    KickConstants constants(group, damping_rates(group, plan.damping), dt);
    switch (plan.kick) {
    case KickKind::undamped: return std::make_unique<KickPass<KickKind::undamped, W>>(std::move(constants));
    case KickKind::constant_rates: return std::make_unique<KickPass<KickKind::constant_rates, W>>(std::move(constants));
    case KickKind::stretched_rates: break;
    }
    return std::make_unique<KickPass<KickKind::stretched_rates, W>>(std::move(constants));
}

/// The step of one group: drift, forces, kick (theory.md (20)).
template <int W> TileProgram<W> make_program(const GroupPlan& plan, const RodGroup& group, double dt) {
    TileProgram<W> program;
    with_top(group, [&]<class Top>(Top) { program.push_back(std::make_unique<DriftPass<Top, W>>()); });
    program.push_back(std::make_unique<OrthonormalisePass<W>>());
    const Walls walls{group.spec().start == EndKind::clamped, group.spec().end == EndKind::clamped};
    program.push_back(std::make_unique<ElasticPass<IncompressibleLaw, W>>(walls));
    for (const Load& load : plan.loads) program.push_back(make_pass<W>(load, group));
    program.push_back(make_kick<W>(plan, group, dt));
    for (const Damping& d : plan.damping)
        if (d.kind == DampingKind::laplacian) program.push_back(std::make_unique<LaplacianFilterPass<W>>(d.order));
    return program;
}

template <int W>
std::unique_ptr<Rods> make_rods_at(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned, const Threads& threads) {
    std::vector<TileProgram<W>> programs;
    for (std::size_t g = 0; g < groups.size(); ++g) programs.push_back(make_program<W>(plan.groups[g], groups[g], plan.dt));
    return std::make_unique<RodTiles<W>>(groups, std::move(owned), std::move(programs), threads);
}

#define SKEIN_MAKE_RODS_AT(W) \
    template std::unique_ptr<Rods> make_rods_at<W>(const Plan&, std::span<const RodGroup>, std::vector<LocalRod>, const Threads&)
extern SKEIN_MAKE_RODS_AT(1);
extern SKEIN_MAKE_RODS_AT(2);
extern SKEIN_MAKE_RODS_AT(4);
extern SKEIN_MAKE_RODS_AT(8);

} // namespace skein
