// From a pass of the plan (plan/program.hpp) to one that runs over tiles, at one width: the one place where run-time
// choices of the scene become template arguments.
#pragma once

#include "contact/wall_pass.hpp"
#include "contact/wall_points.hpp"
#include "immersion/fluid_drag_pass.hpp"
#include "immersion/fluid_load_pass.hpp"
#include "implicit/evaluated_passes.hpp"
#include "kernels/physics_passes.hpp"
#include "kernels/surroundings.hpp"
#include "loads/laplacian_filter.hpp"
#include "loads/load_pass.hpp"
#include "mechanics/audit.hpp"
#include "mechanics/bearing.hpp"
#include "mechanics/body.hpp"
#include "mechanics/elastic.hpp"
#include "mechanics/gyration.hpp"
#include "mechanics/hold.hpp"
#include "mechanics/kick.hpp"
#include "mechanics/slide.hpp"
#include "neighbourhood/surface.hpp"
#include "plan/plan.hpp"
#include "relaxation/relaxation.hpp"
#include "skein/core/index.hpp"
#include "tiles/clusters.hpp"

#include <map>
#include <memory>
#include <stdexcept>

namespace skein {

inline KicksOfGroup kicks_of(const pass::Kick& kick, const GroupPlan& plan, const RodGroup& group, const Scheme& scheme,
                             double dt) {
    KicksOfGroup kicks;
    const DampingRates rates = damping_rates(group, plan.damping);
    for (const double share : scheme.kicks)
        kicks.emplace_back(group, rates, share * (kick.share * dt), plan.damping_scheme);
    return kicks;
}

/// Shares of a group's inertia that its kicks feel in a fluid; none without it.
inline KickedShares kicked_shares(const GroupProgram& program) {
    KickedShares shares;
    const auto* fluid = program.find<pass::FeelFluid>();
    if (!fluid) return shares;
    for (const InertiaShares<double>& node : fluid->inertia->of_nodes) shares.of_nodes.push_back(node.effective);
    for (const InertiaShares<Vec3d>& element : fluid->inertia->of_elements)
        shares.of_elements.push_back(element.effective);
    return shares;
}

/// Calls make.operator()<Kind>() with the kind of kick of rods whose law has an energy.
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

/// Parts that passes of a group's program share, and what they are made from.
template <int W> struct PassParts {
    const GroupPlan& plan;
    const RodGroup& group;
    const Scheme scheme;
    double dt; ///< s
    const Surroundings& around;
    std::shared_ptr<WallContactTiles<W>> walls;     ///< null where none act
    std::shared_ptr<WallTangents<W>> wall_tangents; ///< null where nothing wants them
    std::shared_ptr<BedTiles<W>> bed;               ///< null where steps are others
    std::shared_ptr<EnergyBudget<W>> audit;         ///< null where there is none
    std::shared_ptr<MovingEnds> moving;             ///< null where ends are still
    std::shared_ptr<EndWalls<W>> end_walls;
};

/// Makes the passes of a group whose rods lie across.
template <int W> class PassMaker {
public:
    using Made = std::unique_ptr<TilePass<W>>;
    explicit PassMaker(const PassParts<W>& parts) : parts_(parts) {}

    Made operator()(const pass::Drift& p) const {
        return with_gyration(p.top, []<class Top>(Top) -> Made { return std::make_unique<DriftPass<Top, W>>(); });
    }
    Made operator()(const pass::DriftOnBearings& p) const {
        return with_gyration(
            p.top, [&]<class Top>(Top) -> Made { return std::make_unique<BearingDriftPass<Top, W>>(parts_.group); });
    }
    Made operator()(pass::CloseRing) const { return std::make_unique<CloseRingPass<W>>(); }
    Made operator()(pass::AuditEnds) const { return std::make_unique<AuditEndsPass<W>>(parts_.audit); }
    Made operator()(pass::MoveEnds) const { return std::make_unique<MoveEndsPass<W>>(parts_.moving, parts_.end_walls); }
    Made operator()(pass::Orthonormalise) const { return std::make_unique<OrthonormalisePass<W>>(); }
    Made operator()(pass::Expose) const {
        return std::make_unique<ExposePass<W>>(parts_.around.exposure, parts_.moving ? slot_freedoms(parts_.group)
                                                                                     : std::vector<SlotFreedom>());
    }
    Made operator()(pass::ExposeSurface) const {
        return std::make_unique<ExposeSurfacePass<W>>(parts_.around.exposure, *parts_.group.body());
    }
    Made operator()(pass::Unstrained) const { return std::make_unique<UnstrainedPass<W>>(); }
    Made operator()(const pass::Elastic& p) const {
        if (p.law == Law::elastica) return std::make_unique<ElasticaPass<W>>(ends_of(parts_.group), parts_.end_walls);
        return with_energy_law(p.law, [&]<class L>(L) -> Made {
            return std::make_unique<ElasticPass<L, W>>(ends_of(parts_.group), parts_.end_walls);
        });
    }
    Made operator()(pass::AuditInner) const {
        if (!parts_.group.strained()) return std::make_unique<AuditUnstrainedPass<W>>(parts_.audit);
        return with_energy_law(parts_.group.law(), [&]<class L>(L) -> Made {
            return std::make_unique<AuditInnerPass<L, W>>(parts_.audit, ends_of(parts_.group), parts_.end_walls);
        });
    }
    Made operator()(const pass::ApplyLoad& p) const { return make_pass<W>(p.load, parts_.group); }
    Made operator()(pass::Walls) const { return walls<RodNodes<W>>(); }
    Made operator()(pass::SurfaceWalls) const { return walls<SurfacePoints<W>>(); }
    Made operator()(pass::TakeJoinedLoads) const { return std::make_unique<TakeJoinedLoadsPass<W>>(); }
    Made operator()(pass::TakeLoads) const {
        return std::make_unique<TakeLoadsPass<W>>(parts_.around.exposure, parts_.around.loads);
    }
    Made operator()(pass::TakeSurfaceLoads) const {
        return std::make_unique<TakeSurfaceLoadsPass<W>>(parts_.around.exposure, parts_.around.loads,
                                                         *parts_.group.body());
    }
    Made operator()(const pass::FeelFluid& p) const {
        const GroupProgram& program = parts_.plan.program;
        if (program.find<pass::StepImplicitly>() || program.find<pass::StepInBed>())
            return std::make_unique<FluidDragPass<W>>(parts_.around.fluid);
        return std::make_unique<FluidLoadPass<W>>(parts_.around.fluid, parts_.group, *p.inertia);
    }
    Made operator()(pass::FoldRing) const { return std::make_unique<FoldRingPass<W>>(); }
    Made operator()(pass::AuditLoads) const { return std::make_unique<AuditLoadsPass<W>>(parts_.audit); }
    Made operator()(const pass::Kick& p) const {
        KicksOfGroup kicks = kicks_of(p, parts_.plan, parts_.group, parts_.scheme, parts_.dt);
        if (p.kind == KickKind::elastica) return std::make_unique<KickPass<KickKind::elastica, W>>(std::move(kicks));
        return with_kick(
            p.kind, [&]<KickKind Kind>() -> Made { return std::make_unique<KickPass<Kind, W>>(std::move(kicks)); });
    }
    Made operator()(pass::NoteForces) const { return std::make_unique<NoteForcesPass<W>>(); }
    Made operator()(const pass::Relax& p) const {
        return with_energy_law(p.law, [&]<class L>(L) -> Made {
            return std::make_unique<RelaxPass<L, W>>(parts_.group, p.contacts, parts_.around.residual);
        });
    }
    Made operator()(const pass::StepImplicitly& p) const {
        return make_implicit_pass<W>({parts_.group, p.law, damping_rates(parts_.group, p.damping), parts_.end_walls,
                                      kicked_shares(parts_.plan.program), parts_.audit, p.conserves});
    }
    Made operator()(const pass::StepInBed& p) const {
        return make_bed_pass<W>({{parts_.group, p.law, damping_rates(parts_.group, p.damping), parts_.end_walls,
                                  kicked_shares(parts_.plan.program), parts_.audit, false},
                                 parts_.around.exposure,
                                 parts_.around.loads,
                                 parts_.wall_tangents,
                                 parts_.bed});
    }
    Made operator()(const pass::Filter& p) const {
        const bool audited = p.time == FilterTime::before_step || p.time == FilterTime::after_step;
        const bool before_ends = p.time == FilterTime::before_step && parts_.moving && parts_.scheme.stages.size() > 1;
        return std::make_unique<LaplacianFilterPass<W>>(parts_.group, p.order, p.rate, parts_.dt, p.time,
                                                        audited ? parts_.audit : nullptr,
                                                        before_ends ? parts_.end_walls : nullptr);
    }
    Made operator()(pass::Slide) const { return std::make_unique<SlidePass<W>>(parts_.end_walls); }
    Made operator()(pass::Hold) const { return std::make_unique<HoldPass<W>>(); }
    Made operator()(const pass::Bearings& p) const {
        std::vector<Vec3d> shares = kicked_shares(parts_.plan.program).of_elements;
        if (p.kind == KickKind::undamped) return std::make_unique<BearingPass<W>>(parts_.group, shares);
        KicksOfGroup kicks = kicks_of(pass::Kick{p.kind, p.share}, parts_.plan, parts_.group, parts_.scheme, parts_.dt);
        return with_kick(p.kind, [&]<KickKind Kind>() -> Made {
            return std::make_unique<DampedBearingPass<Kind, W>>(parts_.group, std::move(kicks), std::move(shares));
        });
    }
    Made operator()(pass::AuditMedium) const { return std::make_unique<AuditMediumPass<W>>(parts_.audit); }
    Made operator()(pass::AuditMediumWork) const {
        return std::make_unique<AuditMediumWorkPass<W>>(parts_.audit, parts_.moving != nullptr);
    }
    Made operator()(pass::AuditBalance) const {
        return std::make_unique<AuditBalancePass<W>>(parts_.audit, parts_.moving != nullptr);
    }

private:
    template <class Points> Made walls() const {
        const GroupProgram& program = parts_.plan.program;
        const bool in_stages = program.find<pass::StepImplicitly>() != nullptr;
        return std::make_unique<WallPass<W, Points>>(parts_.around.walls, parts_.group, parts_.walls,
                                                     parts_.wall_tangents, in_stages);
    }
    const PassParts<W>& parts_;
};

/// Makes the passes of a family of groups that differ in constants alone, whose rods lie along.
template <int W> class AlongPassMaker {
public:
    using Made = std::unique_ptr<TilePass<W>>;
    using Map = Along<W>;
    AlongPassMaker(const Plan& plan, std::span<const RodGroup> groups, int family, const Surroundings& around)
        : plan_(plan), around_(around) {
        for (std::size_t g = 0; g < groups.size(); ++g)
            if (plan.groups[g].family == family) family_.push_back(&groups[g]);
        if (this->plan().program.template find<pass::Walls>())
            walls_ = std::make_shared<WallContactTiles<W>>(*around.walls, *family_.front());
        if (this->plan().program.template find<pass::AuditBalance>())
            audit_ = std::make_shared<EnergyBudget<W>>(*family_.front());
    }
    /// Contacts with walls of rods that are whole; null where none act.
    const std::shared_ptr<WallContactTiles<W>>& walls() const { return walls_; }
    /// Energy budget of these rods; null without an audit.
    const std::shared_ptr<EnergyBudget<W>>& audit() const { return audit_; }
    /// The plan that all of them have.
    const GroupPlan& plan() const { return plan_of(*family_.front()); }

    Made operator()(const pass::Drift& p) const {
        return with_gyration(p.top, []<class Top>(Top) -> Made {
            if constexpr (std::is_same_v<Top, EllipticGyrationOfEach>)
                throw std::logic_error("tops of each element's own, in a family");
            else return std::make_unique<DriftPass<Top, W, Map>>();
        });
    }
    Made operator()(pass::Orthonormalise) const { return std::make_unique<OrthonormalisePass<W, Map>>(); }
    Made operator()(const pass::Elastic& p) const {
        Ends ends;
        for (const RodGroup* group : family_) ends.start_wall |= ends_of(*group).start_wall;
        return with_energy_law(p.law,
                               [&]<class L>(L) -> Made { return std::make_unique<ElasticPass<L, W, Map>>(ends); });
    }
    Made operator()(const pass::ApplyLoad& p) const { return make_pass<W, Map>(p.load, *family_.front()); }
    Made operator()(const pass::Kick& p) const {
        const Scheme scheme = scheme_of(plan_.integrator);
        std::map<int, KicksOfGroup> kicks;
        for (const RodGroup* group : family_)
            kicks.emplace(group->id(), kicks_of(p, plan_of(*group), *group, scheme, plan_.dt));
        std::function<KicksOfGroup(const RodGroup&)> of_rod;
        if (family_.front()->heterogeneous())
            of_rod = [p, one = plan(), scheme, dt = plan_.dt](const RodGroup& rod) {
                return kicks_of(p, one, rod, scheme, dt);
            };
        return with_kick(p.kind, [&]<KickKind Kind>() -> Made {
            return std::make_unique<KickAlongPass<Kind, W>>(std::move(kicks), std::move(of_rod));
        });
    }
    Made operator()(pass::Slide) const { return std::make_unique<SlidePass<W, Map>>(); }
    Made operator()(pass::Hold) const { return std::make_unique<HoldPass<W>>(); }
    Made operator()(pass::Expose) const { return std::make_unique<ExposePass<W, Map>>(around_.exposure); }
    Made operator()(pass::TakeLoads) const {
        return std::make_unique<TakeLoadsPass<W>>(around_.exposure, around_.loads);
    }
    Made operator()(const pass::Walls&) const {
        return std::make_unique<WallPass<W, RodNodes<W, Map>>>(around_.walls, *family_.front(), walls_);
    }
    Made operator()(pass::AuditInner) const { return std::make_unique<AuditUnstrainedPass<W>>(audit_); }
    Made operator()(pass::AuditLoads) const { return std::make_unique<AuditLoadsPass<W>>(audit_); }
    Made operator()(pass::AuditBalance) const { return std::make_unique<AuditBalancePass<W>>(audit_, false); }
    template <class Other> Made operator()(const Other&) const {
        throw std::logic_error("a pass that looks at whole rods, in a family"); // see GroupProgram::lies_along
    }

private:
    const GroupPlan& plan_of(const RodGroup& group) const { return nth(plan_.groups, group.id()); }

    const Plan& plan_;
    const Surroundings& around_;
    std::vector<const RodGroup*> family_;
    std::shared_ptr<WallContactTiles<W>> walls_;
    std::shared_ptr<EnergyBudget<W>> audit_;
};

} // namespace skein
