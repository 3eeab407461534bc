#include "physics/relaxation/relaxation_tables.hpp"

#include "coupling/interaction.hpp"
#include "joints/joint_limits.hpp"
#include "joints/joint_list.hpp"
#include "kernels/physics_passes.hpp"
#include "kernels/surroundings.hpp"
#include "physics/contact/laws_of_group.hpp"
#include "physics/plan_input.hpp"
#include "physics/relaxation/relaxation_interaction.hpp"
#include "plan/plan.hpp"
#include "plan/plan_line.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "tiles/clusters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace skein {

namespace {

/// As stiff as any of a group's contacts is at the largest overlap that is allowed, on a node that touches four others.
RelaxationContacts relaxation_contacts(const ContactTables& tables, const WallTables& walls, const RodGroup& group) {
    constexpr double farthest_move = 0.2; // of the radius in a step
    constexpr int touching = 4;
    RelaxationContacts contacts;
    double radius = HUGE_VAL;
    for (const ElementConstants& e : group.element) radius = std::min(radius, e.radius);
    with_contact_laws(tables, walls, group, [&](const ContactLaw& law, double share, double mass) {
        const double k = touching * tangent_stiffness(law.resolved(mass), share * 2 * radius);
        contacts.stiffness = std::max(contacts.stiffness, k);
        if (law.friction != ContactFriction::none) contacts.turning = std::max(contacts.turning, k * radius * radius);
        contacts.farthest_move = farthest_move * radius;
    });
    return contacts;
}

/// Inertia that is no true one does not carry what is dragged along.
void refuse_drag(const GroupPlan& p, const RodGroup& group) {
    for (const PassSpec& pass : p.program)
        if (const auto* apply = pass.get<pass::ApplyLoad>(); apply && apply->load.largest_rate(group).value > 0)
            throw InputError(
                fmt::format("{}: a load of kind {} slows '{}' down, and time.relax has no motion that it could answer",
                            group.spec().source, apply->load.kind(), group.name()));
}

class PlannedRelaxation final : public PhysicsPlan, public StartsInteraction, public SharesWithPasses {
public:
    explicit PlannedRelaxation(const PlanInput& input)
        : tolerance_(input.scene.time.relax_tolerance), contact_(input.scene), walls_(input.scene) {
        std::vector<std::vector<Joint>> joints;
        for (const AssemblyGroups& of : assemblies_of(input.groups))
            joints.push_back(joints_of(input.scene.joints, input.groups, of.assembly));
        holds_ = joint_holds(input.scene.joints, joints, input.groups);
        shared_.resize(input.groups.size());
        for (const std::vector<Joint>& assembly : joints)
            for (const Hub& hub : junctions_of(input.scene.joints, assembly, input.groups).hubs)
                for (const Hub::Member& m : hub.members) nth(shared_, m.group).insert(m.node);
    }

    std::string summary(const Plan&) const override { return "relaxation"; }
    std::vector<PlanLine> describe(const Plan&) const override {
        return {{"relaxation", fmt::format("rods have settled when none wants a correction beyond {:g}", tolerance_),
                 "relax_tolerance", tolerance_}};
    }
    void add_passes(GroupPlan& p, const RodGroup& group) const override {
        refuse_drag(p, group);
        RelaxationContacts contacts = relaxation_contacts(contact_, walls_, group);
        contacts.node = nth(holds_, group.id()).node;
        contacts.turn = nth(holds_, group.id()).turn;
        contacts.shared.assign(nth(shared_, group.id()).begin(), nth(shared_, group.id()).end());
        if (p.program.has(PassPlace::boundaries) || p.program.has(PassPlace::neighbours) || contacts.any())
            p.program.add(PassPlace::loads_done, pass::NoteForces{});
        p.program.replace(PassPlace::kick, pass::Relax{group.law(), std::move(contacts)});
        p.program.replace(PassPlace::bearings, pass::Bearings{});
    }
    /// Steps of 1 s, half of what M of theory.md (64) leaves.
    bool sets_step(Plan& plan, const CoreTables& scene) override {
        plan.pseudo_time = plan.automatic_dt = plan.force_dt = true;
        plan.dt = 1;
        plan.limit = 2;
        plan.steps = std::max<std::int64_t>(1, std::llround(scene.time.duration));
        return true;
    }

    void share(Surroundings& around, std::span<const RodGroup> groups, std::span<const LocalRod>) const override {
        around.residual = std::make_shared<RelaxationResidual>(groups.size());
    }
    std::unique_ptr<Interaction> start(const InteractionParts& parts) const override {
        return std::make_unique<RelaxationInteraction>(parts, tolerance_);
    }

private:
    double tolerance_; ///< correction at which rods have settled
    ContactTables contact_;
    WallTables walls_;
    std::vector<JointHolds> holds_;     ///< by group
    std::vector<std::set<int>> shared_; ///< by group: nodes that are one with others
};

} // namespace

bool RelaxationTables::look_at_whole_rods(const SceneSpec& scene, const RodSpec&) { return scene.time.relax; }

void RelaxationTables::plan(const PlanInput& input, PlannedPhysics& out) {
    if (input.scene.time.relax) out.add<PlannedRelaxation>(input);
}

} // namespace skein
