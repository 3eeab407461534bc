#include "joints/joint_events.hpp"
#include "kernels/physics_passes.hpp"
#include "kernels/surroundings.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "physics/implicit/bed_plan.hpp"
#include "physics/implicit/body_speeds.hpp"
#include "physics/implicit/implicit_interaction.hpp"
#include "physics/implicit/implicit_tables.hpp"
#include "physics/implicit/step_filters.hpp"
#include "physics/plan_input.hpp"
#include "physics/wave_looker.hpp"
#include "plan/plan.hpp"
#include "plan/plan_line.hpp"
#include "plan/plan_steps.hpp"
#include "rod/bearing.hpp"
#include "rod/body_shape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// Shortest period that a load or a motion of an end has by its keys, s. Formulas have none.
double shortest_period(const SceneSpec& scene) {
    WaveLooker wave;
    for (LoadSpec load : scene.loads) load.fields(wave); // fields() hands out references to change
    for (const RodSpec& rods : scene.rods)
        for (EndMotion motion : {rods.start_motion, rods.end_motion}) motion.fields(wave);
    return wave.period;
}

/// Steps of a length that stability does not limit.
class PlannedImplicitSteps final : public PhysicsPlan, public StartsInteraction, public SharesWithPasses {
public:
    explicit PlannedImplicitSteps(const PlanInput& input)
        : integrator_(input.scene.time.integrator), in_fluid_(input.scene.fluid.has_value()),
          audited_(input.scene.output.audit), touches_(input.scene.contact.has_value()),
          tolerance_(in_fluid_ ? 0.0 : input.scene.time.tolerance),
          remembers_(!input.scene.walls.empty() ||
                     std::any_of(input.scene.joints.begin(), input.scene.joints.end(), remembers)) {
        period_ = shortest_period(input.scene);
        for (const RodGroup& group : input.groups) radius_ = std::min(radius_, thinnest(group));
        for (const RodGroup& group : input.groups)
            length_ = std::max(length_, group.strained() ? group.spec().shape.length : 2 * group.body()->reach);
    }

    std::string summary(const Plan&) const override { return "implicit steps"; }
    std::vector<PlanLine> describe(const Plan& plan) const override {
        std::vector<PlanLine> lines;
        if (plan.automatic_dt && in_fluid_)
            lines.push_back(
                {"implicit",
                 "one step of rods in a stage of the fluid's, in more parts where corrections do not converge",
                 "",
                 {}});
        else if (plan.automatic_dt)
            lines.push_back({"implicit",
                             fmt::format("each step in as many parts as keep the error of positions below {:g} of {:g} "
                                         "m in the whole run",
                                         tolerance_, length_),
                             "tolerance", tolerance_});
        if (touches_)
            lines.push_back(
                {"touching",
                 fmt::format("parts of steps are as short as contacts need where rods are nearer than {:.3g} "
                             "m, {:g} of the radius, and no node goes farther in one",
                             way * radius_, way),
                 "way_in_a_part", way * radius_});
        return lines;
    }
    /// Contacts note pairs that a node could bring together in a part of a step.
    void share(Surroundings& around, std::span<const RodGroup>, std::span<const LocalRod>) const override {
        if (around.loads) around.meeting_zone = way * radius_;
    }
    std::unique_ptr<Interaction> start(const InteractionParts& parts) const override {
        return std::make_unique<ImplicitInteraction>(
            parts, ImplicitInteraction::Needs{.tolerance = parts.plan.automatic_dt ? tolerance_ : 0.0,
                                              .length = length_,
                                              .remembers = remembers_,
                                              .way = touches_ ? way * radius_ : HUGE_VAL,
                                              .period = period_});
    }
    void add_passes(GroupPlan& p, const RodGroup& group) const override {
        p.program.remove(PassPlace::drift);
        p.program.remove(PassPlace::internal);
        const bool keeps_energy = integrator_ == Integrator::implicit && bearings_of(group).empty();
        p.program.replace(PassPlace::kick, pass::StepImplicitly{group.law(), p.damping, keeps_energy, audited_});
        split_filters(p);
        p.program.replace(PassPlace::bearings, pass::Bearings{});
    }
    bool sets_step(Plan& plan, const CoreTables& scene) override {
        plan.integrator = integrator_;
        plan.force_dt = true;
        plan.rest_speed = scene.time.rest_speed;
        find_governing(plan, scene);
        plan.automatic_dt = scene.time.dt == 0;
        plan.dt = scene.time.dt;
        if (in_fluid_) { // which the clock follows
            for (const auto& one : plan.physics)
                if (!plan.automatic_dt) one->take_given_step(plan, scene);
                else if (one->divides_interval(plan, scene, HUGE_VAL)) break;
            if (const auto* fluid = plan.find<FluidPlan>(); fluid && plan.automatic_dt)
                plan.steps_at_once = static_cast<double>(fluid->every) / stage_parts(fluid->constants.scheme).count;
        } else if (plan.automatic_dt) { // steps are cut into parts
            const double longest = scene.time.duration / fewest_steps;
            const Interval interval = interval_to_divide(plan, scene, longest);
            plan.divides = interval.text();
            plan.dt = interval.length / std::ceil(interval.length / longest * (1 - 1e-12));
        }
        plan.steps = whole_steps(scene.time.duration, plan);
        return true;
    }

private:
    static constexpr double fewest_steps = 64; ///< of the duration
    /// Way of the fastest node in a part of a step, over the radius, with which contacts are met before they are deep.
    static constexpr double way = 0.15;

    /// Half of each filter before a step and half after it, in opposite orders. In steps that keep energy ends are at
    /// the middle both times; in others they are at the begin and at the end.
    void split_filters(GroupPlan& p) const {
        std::vector<pass::Filter> filters = take_filters(p);
        add_filters(p, PassPlace::filter, FilterTime::after_step, filters);
        std::reverse(filters.begin(), filters.end());
        add_filters(p, integrator_ == Integrator::implicit ? PassPlace::expose : PassPlace::drift,
                    FilterTime::before_step, filters);
    }

    Integrator integrator_;
    bool in_fluid_, audited_, touches_;
    double tolerance_, length_ = 0; ///< of the length; m
    double radius_ = HUGE_VAL;      ///< of the thinnest element, m
    double period_ = HUGE_VAL;      ///< shortest of a drive, s
    bool remembers_;                ///< joints or contacts with walls
};

} // namespace

bool ImplicitTables::look_at_whole_rods(const SceneSpec& scene, const RodSpec&) {
    return is_implicit(scene.time.integrator);
}

void ImplicitTables::plan(const PlanInput& input, PlannedPhysics& out) {
    const TimeSpec& time = input.scene.time;
    if (time.relax || !is_implicit(time.integrator) || input.groups.empty()) return;
    if (time.integrator == Integrator::implicit_bed) plan_bed(input, out);
    else out.add<PlannedImplicitSteps>(input);
}

} // namespace skein
