#include "physics/audit/audit_plan.hpp"

#include "kernels/physics_passes.hpp"
#include "mechanics/audit.hpp"
#include "physics/audit/audit_tables.hpp"
#include "physics/plan_input.hpp"
#include "plan/plan.hpp"

namespace skein {

namespace {

class PlannedAudit final : public PhysicsPlan, public AuditPlan {
public:
    explicit PlannedAudit(Integrator integrator)
        : AuditPlan{integrator == Integrator::implicit || integrator == Integrator::implicit_damped},
          in_bed_(integrator == Integrator::implicit_bed) {}

    std::string summary(const Plan&) const override { return "energy audit"; }
    void add_passes(GroupPlan& p, const RodGroup& group) const override {
        if (group.spec().ends_move()) p.program.add(PassPlace::before_ends, pass::AuditEnds{});
        if (by_steps) return; // they book the rest
        p.program.add(PassPlace::internal_done, pass::AuditInner{});
        if (p.program.has(PassPlace::neighbours)) {
            p.program.add(PassPlace::before_neighbours, pass::AuditLoads{});
            p.program.add(PassPlace::neighbours_done, pass::AuditInner{});
        }
        p.program.add(PassPlace::sum_done, pass::AuditLoads{});
        if (p.program.has(PassPlace::medium)) {
            if (!in_bed_) p.program.add(PassPlace::medium_done, pass::AuditMedium{}); // the step of a bed does it
            p.program.add(PassPlace::balance, pass::AuditMediumWork{});
        }
        p.program.add(PassPlace::balance, pass::AuditBalance{});
    }
    void add_bytes(Plan& plan, std::span<const RodGroup>) override {
        for (const GroupPlan& p : plan.groups) {
            const std::size_t loads = p.program.has(PassPlace::medium) ? 3 : 2;
            plan.state_bytes += static_cast<double>(p.tiles) * (p.elements + 1) *
                                static_cast<double>(loads * sizeof(SlotLoad<1>) + sizeof(EnergyBudget<1>::Rates)) *
                                plan.machine.lanes;
        }
    }

private:
    bool in_bed_;
};

} // namespace

bool AuditTables::look_at_whole_rods(const SceneSpec& scene, const RodSpec&) { return scene.output.audit; }

void AuditTables::plan(const PlanInput& input, PlannedPhysics& out) {
    if (input.scene.output.audit)
        out.add<PlannedAudit>(input.scene.time.relax ? Integrator::verlet : input.scene.time.integrator);
}

} // namespace skein
