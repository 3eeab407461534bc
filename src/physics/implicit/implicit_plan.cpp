#include "kernels/physics_passes.hpp"
#include "physics/implicit/implicit_tables.hpp"
#include "physics/plan_input.hpp"
#include "plan/plan.hpp"
#include "plan/plan_line.hpp"
#include "plan/plan_steps.hpp"

#include <cmath>

namespace skein {

namespace {

/// Steps of a length that stability does not limit.
class PlannedImplicitSteps final : public PhysicsPlan {
public:
    explicit PlannedImplicitSteps(const PlanInput& input) : integrator_(input.scene.time.integrator) {}

    std::string summary(const Plan&) const override { return "implicit steps"; }
    void add_passes(GroupPlan& p, const RodGroup& group) const override {
        p.program.remove(PassPlace::drift);
        p.program.remove(PassPlace::internal);
        p.program.replace(PassPlace::kick, pass::StepImplicitly{group.law(), p.damping});
    }
    bool sets_step(Plan& plan, const CoreTables& scene) override {
        plan.integrator = integrator_;
        plan.force_dt = true;
        plan.rest_speed = scene.time.rest_speed;
        plan.dt = scene.time.dt;
        plan.limit = HUGE_VAL;
        plan.steps = whole_steps(scene.time.duration, plan);
        return true;
    }

private:
    Integrator integrator_;
};

} // namespace

void ImplicitTables::plan(const PlanInput& input, PlannedPhysics& out) {
    if (!input.scene.time.relax && is_implicit(input.scene.time.integrator)) out.add<PlannedImplicitSteps>(input);
}

} // namespace skein
