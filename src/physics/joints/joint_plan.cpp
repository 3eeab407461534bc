#include "physics/joints/joint_plan.hpp"

#include "coupling/interaction.hpp"
#include "formula/vector_of_time.hpp"
#include "joints/joint_limits.hpp"
#include "joints/junction.hpp"
#include "kernels/physics_passes.hpp"
#include "kernels/surroundings.hpp"
#include "physics/assemblies.hpp"
#include "physics/joints/joint_interaction.hpp"
#include "physics/plan_input.hpp"
#include "physics/tightened.hpp"
#include "plan/plan.hpp"
#include "plan/plan_line.hpp"
#include "plan/plan_words.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "tiles/clusters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

std::string axis_text(const AxisSpec& axis) {
    std::string text;
    if (axis.spring > 0) text += fmt::format(", spring {:.4g} along its axis", axis.spring);
    if (!axis.limits.empty()) text += fmt::format(", stops at {:g} and {:g}", axis.limits[0], axis.limits[1]);
    if (axis.friction > 0) text += fmt::format(", friction {:.4g}", axis.friction);
    if (axis.motor.kind != MotorKind::none)
        text += fmt::format(", motor of given {}", nth(motor_names, axis.motor.kind));
    return text;
}

std::string joint_text(const JointSpec& joint, std::size_t count) {
    const JointLaw& law = joint.law;
    std::string text =
        fmt::format("{} {}, '{}' to '{}', ", count, nth(joint_names, joint.kind), joint.between[0], joint.between[1]);
    if (!shares_node(joint)) text += fmt::format("k {:.4g} N/m", law.stiffness);
    else text += turns_by_half_cells(joint) ? "as within a rod" : "a common node";
    if (law.damping > 0) text += fmt::format(", dashpot {:.4g} N s/m", law.damping);
    if (law.torsional_stiffness > 0) text += fmt::format(", torsional {:.4g} N m/rad", law.torsional_stiffness);
    if (law.torsional_damping > 0) text += fmt::format(", {:.4g} N m s/rad", law.torsional_damping);
    if (law.repulsion > 0) text += fmt::format(", repulsion {:.4g} N/m^1.5", law.repulsion);
    text += axis_text(joint.axis_law);
    if (law.cone > 0) text += fmt::format(", a cone of {:g} rad", law.cone);
    if (joint.about_second.any()) text += ", about its second axis" + axis_text(joint.about_second);
    const JointEvents& events = joint.events;
    if (events.from > 0) text += fmt::format(", made at {:g} s", events.from);
    if (events.until > 0) text += fmt::format(", until {:g} s", events.until);
    if (events.break_force > 0) text += fmt::format(", breaks at {:.4g} N", events.break_force);
    if (events.break_strain > 0) text += fmt::format(", tears at a strain of {:g}", events.break_strain);
    return text;
}

/// Rods that do not bend beside a joint, in the half cells at their ends.
std::vector<std::string> rigid_joints(std::span<const JointSpec> joints, std::span<const RodGroup> groups) {
    std::vector<std::string> found;
    constexpr double much = 2; // times the half cells' stiffness
    for (std::size_t j = 0; j < joints.size(); ++j) {
        const JointSpec& joint = joints[j];
        if (joint.kind != JointKind::fixed || !(joint.law.torsional_stiffness > 0)) continue;
        double compliance = 0, rigid = 0; // rad/(N m), m
        for (const RodGroup& group : groups)
            for (std::size_t side = 0; side < joint.between.size(); ++side) {
                const double at = joint.at[side];
                if (group.name() != joint.between[side] || !group.strained() || group.heterogeneous() ||
                    (at != 0 && at != 1))
                    continue;
                const ElementConstants& element = at == 0 ? group.element.front() : group.element.back();
                compliance += 0.5 * element.rest_length / element.bending.x;
                rigid += 0.5 * element.rest_length;
            }
        if (compliance * joint.law.torsional_stiffness > much)
            found.push_back(fmt::format("joint.{}: torsional_stiffness = {:g} N m/rad is {:.2g} times that of the half "
                                        "cells at the ends that it joins, in "
                                        "which the rods do not bend themselves: they bend as if {:.2g} m of them were "
                                        "rigid; stiffness = \"auto\" without "
                                        "a torsional_stiffness bends there as within a rod",
                                        j, joint.law.torsional_stiffness, compliance * joint.law.torsional_stiffness,
                                        rigid));
    }
    return found;
}

/// Motors whose formulas hold `rod` are tried for each rod that has one.
void take_motors_of_rods(JointLists& lists, std::span<const RodGroup> groups, double duration) {
    constexpr int times = 64;
    const std::vector<AssemblyGroups> assemblies = assemblies_of(groups);
    for (std::size_t a = 0; a < assemblies.size(); ++a) {
        std::vector<double> rods(to_index(assemblies[a].groups.front()->assembly()->count()));
        for (const Joint& joint : lists.of_assembly[a]) {
            JointSpec& table = lists.tables[joint.table];
            if (!table.motors_by_rod()) continue;
            for (std::size_t copy = 0; copy < rods.size(); ++copy)
                rods[copy] = rod_number(joint, groups, static_cast<std::int64_t>(copy));
            for (Motor* motor : {&table.axis_law.motor, &table.about_second.motor}) {
                if (!motor->by_rod()) continue;
                const VectorOfTime::Tried tried = motor->formula->try_rods(duration, times, rods);
                if (tried.not_finite)
                    throw InputError(fmt::format("{}: the motor's value or rate is not finite for rod {:.0f} of "
                                                 "'{}' at some time of the run: give its formula a value for "
                                                 "each rod",
                                                 table.source, *tried.not_finite, table.between[0]));
                motor->largest = std::max(motor->largest, tried.largest.x);
            }
        }
    }
}

class PlannedJoints final : public PhysicsPlan, public JointPlan, public StartsInteraction, public SharesWithPasses {
public:
    explicit PlannedJoints(const PlanInput& input) {
        const SceneSpec& scene = input.scene;
        auto lists = std::make_shared<JointLists>();
        lists->tables = scene.joints;
        for (JointSpec& table : lists->tables) {
            table.use(names_for_formulas(scene));
            if (scene.time.relax) table.take_away_dashpots(); // pseudo-velocities are none
        }
        for (const AssemblyGroups& of : assemblies_of(input.groups)) {
            AssemblyPlan& p = assemblies.emplace_back();
            p.name = assembly_name(scene, of.assembly);
            p.copies = of.groups.front()->assembly()->count();
            for (const RodGroup* group : of.groups) {
                p.rods += group->rods_per_copy();
                p.elements += group->rods_per_copy() * group->elements();
            }
            p.joints_of_table.assign(scene.joints.size(), 0);
            lists->of_assembly.push_back(joints_of(scene.joints, input.groups, of.assembly));
            for (const Joint& joint : lists->of_assembly.back()) ++p.joints_of_table[joint.table];
        }
        take_motors_of_rods(*lists, input.groups, scene.time.duration);
        bounds_ = joint_bounds(lists->tables, lists->of_assembly, input.groups);
        joints = std::move(lists);
    }

    std::string summary(const Plan&) const override {
        std::int64_t count = 0;
        for (std::size_t a = 0; a < assemblies.size(); ++a)
            count += assemblies[a].copies * static_cast<std::int64_t>(joints->of_assembly[a].size());
        return count > 0 ? counted(count, "joint") : "assemblies";
    }
    std::vector<PlanLine> describe(const Plan&) const override {
        std::vector<PlanLine> lines;
        nlohmann::ordered_json json = nlohmann::ordered_json::array();
        for (std::size_t a = 0; a < assemblies.size(); ++a) {
            const AssemblyPlan& p = assemblies[a];
            const auto count = static_cast<std::int64_t>(joints->of_assembly[a].size());
            lines.push_back({"assembly",
                             fmt::format("'{}': {}, of {} with {} elements and {}", p.name,
                                         p.copies == 1 ? "1 copy" : fmt::format("{} copies", p.copies),
                                         counted(p.rods, "rod"), p.elements, counted(count, "joint")),
                             "",
                             {}});
            for (std::size_t t = 0; t < p.joints_of_table.size(); ++t)
                if (p.joints_of_table[t] > 0)
                    lines.push_back({"  joints", joint_text(joints->tables[t], p.joints_of_table[t]), "", {}});
            json.push_back({{"name", p.name}, {"copies", p.copies}, {"rods", p.rods}, {"joints", count}});
        }
        lines.push_back({"", "", "assemblies", json});
        return lines;
    }
    std::vector<std::string> notes(const Plan&, std::span<const RodGroup> groups) const override {
        std::vector<std::string> found = rigid_joints(joints->tables, groups);
        for (std::size_t t = 0; t < joints->tables.size(); ++t) {
            const JointSpec& table = joints->tables[t];
            const Vec3d& along = table.law.along;
            const bool free_way = table.kind == JointKind::bushing && std::min({along.x, along.y, along.z}) == 0;
            const bool slides = table.kind == JointKind::slider && !table.to_world() && table.axis_law.reach() == 0;
            if (!slides && !free_way) continue;
            double way = HUGE_VAL;
            for (const auto& of_assembly : joints->of_assembly)
                for (const Joint& joint : of_assembly)
                    if (joint.table == t) way = std::min(way, slider_way(table, joint));
            found.push_back(
                fmt::format("joint.{}: nothing says how far it {}; its step holds for ways up to {:.3g} m: {}", t,
                            slides ? "slides" : "moves along an axis of share 0", way,
                            slides ? "give 'limits', or name the body first that is carried along"
                                   : "give a share above 0, or a shorter 'dt' for longer ways"));
        }
        return found;
    }

    void add_passes(GroupPlan& p, const RodGroup& group) const override {
        if (is_joined(group)) p.program.add(PassPlace::connections, pass::TakeJoinedLoads{});
    }
    /// Stiffness and drag of joints add to those of rods.
    void tighten_limits(GroupPlan& p, const RodGroup& group, const Scheme& scheme) const override {
        if (!is_joined(group)) return;
        const JointBounds& bounds = nth(bounds_, group.id());
        if (bounds.eigenvalue > 0) // beside a junction elements have one cell more than at an end
            p.limit("joints", 2 / std::sqrt(bounds.eigenvalue / p.effective_inertia()), bounds.element_of_eigenvalue);
        if (bounds.stiffness > 0) {
            const double rate = p.limits.empty() ? 0 : 2 / p.limits.front().dt;
            p.limit("joints", stiffened(rate, bounds.stiffness / p.effective_inertia()), bounds.element);
        }
        if (bounds.drag == 0) return;
        const double fastest = p.limits.front().dt,
                     half = 0.5 * fastest * scheme.stability * bounds.drag / (scheme.drag * p.effective_inertia());
        p.limit("joints", slowed(fastest, half), bounds.element);
    }

    void share(Surroundings& around, std::span<const RodGroup>, std::span<const LocalRod>) const override {
        around.joints = joints;
    }
    std::unique_ptr<Interaction> start(const InteractionParts& parts) const override {
        return joints->tables.empty() ? nullptr : std::make_unique<JointInteraction>(parts, *this);
    }

private:
    bool is_joined(const RodGroup& group) const {
        return group.assembly() && !nth(joints->of_assembly, group.assembly()->number).empty();
    }

    std::vector<JointBounds> bounds_; ///< by group
};

} // namespace

void JointTables::plan(const PlanInput& input, PlannedPhysics& out) {
    if (!assemblies_of(input.groups).empty()) out.add<PlannedJoints>(input);
}

} // namespace skein
