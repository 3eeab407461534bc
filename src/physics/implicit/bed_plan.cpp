#include "physics/implicit/bed_plan.hpp"

#include "coupling/interaction.hpp"
#include "kernels/physics_passes.hpp"
#include "kernels/surroundings.hpp"
#include "loads/gravity.hpp"
#include "physics/implicit/bed_interaction.hpp"
#include "physics/implicit/body_speeds.hpp"
#include "physics/implicit/step_filters.hpp"
#include "physics/plan_input.hpp"
#include "plan/plan.hpp"
#include "plan/plan_line.hpp"
#include "plan/plan_steps.hpp"
#include "rod/body_shape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// Steps of rods in contact, which neither elasticity nor contact limits.
class PlannedBed final : public PhysicsPlan, public StartsInteraction, public SharesWithPasses {
public:
    explicit PlannedBed(const PlanInput& input) : in_fluid_(input.scene.fluid.has_value()) {
        for (const RodGroup& group : input.groups) radius_ = std::min(radius_, thinnest(group));
        for (const LoadSpec& of : input.scene.loads)
            if (const auto* gravity = of.load.get_if<Gravity>())
                gravity_ = std::max(gravity_, norm(gravity->acceleration));
    }

    std::string summary(const Plan&) const override { return "steps of a bed"; }
    std::vector<PlanLine> describe(const Plan&) const override {
        return {{"bed",
                 fmt::format("first order; steps are cut where a node would go farther than {:.3g} m, {:g} of "
                             "the radius",
                             way * radius_, way),
                 "way_in_a_step", way * radius_}};
    }
    void share(Surroundings& around, std::span<const RodGroup>, std::span<const LocalRod>) const override {
        if (around.loads) around.loads->has_tangents = true;
        around.meeting_zone = meeting_zone_;
    }
    std::unique_ptr<Interaction> start(const InteractionParts& parts) const override {
        return std::make_unique<BedInteraction>(parts, way * radius_);
    }
    void add_passes(GroupPlan& p, const RodGroup& group) const override {
        p.program.replace(PassPlace::kick, pass::StepInBed{group.law(), p.damping});
        add_filters(p, PassPlace::filter, FilterTime::whole_step, take_filters(p));
        p.program.replace(PassPlace::bearings, pass::Bearings{});
    }
    Coupling coupling() const override { return Coupling::every_step; }
    bool sets_step(Plan& plan, const CoreTables& scene) override {
        plan.integrator = Integrator::implicit_bed;
        plan.force_dt = true;
        plan.rest_speed = scene.time.rest_speed;
        find_governing(plan, scene);
        plan.automatic_dt = scene.time.dt == 0;
        plan.dt = scene.time.dt;
        const double longest = longest_step_of(plan, scene);
        if (in_fluid_) {
            for (const auto& one : plan.physics)
                if (!plan.automatic_dt) one->take_given_step(plan, scene);
                else if (one->divides_interval(plan, scene, longest)) break;
        } else if (plan.automatic_dt) {
            const Interval interval = interval_to_divide(plan, scene, longest);
            plan.divides = interval.text();
            plan.dt = interval.length / std::ceil(interval.length / longest * (1 - 1e-12));
        }
        plan.steps = whole_steps(scene.time.duration, plan);
        meeting_zone_ = std::min(gravity_ * plan.dt * plan.dt, way * radius_);
        return true;
    }

private:
    /// Way of the fastest node in a step, over the radius: where the prediction goes deeper into a contact than it
    /// could by motion, the linear solution overshoots.
    static constexpr double way = 0.15;
    /// Step over the limit of explicit contact. Nests have figures near those of explicit steps up to here; contacts,
    /// most of them less deep than that limit allows for, add about their mass (docs/long_steps.md).
    static constexpr double over_contact_limit = 25;

    static double longest_step_of(const Plan& plan, const CoreTables& scene) {
        double limit = HUGE_VAL;
        for (const GroupPlan& group : plan.groups)
            for (const TimeLimit& of : group.limits)
                if (of.mode == "contact") limit = std::min(limit, of.dt);
        constexpr double fewest_steps = 64; // of the duration
        return std::min(over_contact_limit * limit, scene.time.duration / fewest_steps);
    }

    bool in_fluid_;
    double radius_ = HUGE_VAL; ///< of the thinnest element, m
    double gravity_ = 0;       ///< largest, m/s^2
    double meeting_zone_ = 0;  ///< way that gravity adds in a step, m: so far rods may fall into each other unseen
};

} // namespace

void plan_bed(const PlanInput& input, PlannedPhysics& out) { out.add<PlannedBed>(input); }

} // namespace skein
