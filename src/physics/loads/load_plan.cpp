#include "physics/loads/load_plan.hpp"

#include "kernels/physics_passes.hpp"
#include "loads/formula_load.hpp"
#include "loads/plane_friction.hpp"
#include "physics/group_names.hpp"
#include "physics/loads/formula_doubts.hpp"
#include "physics/loads/plane_numbers.hpp"
#include "physics/plan_input.hpp"
#include "physics/tightened.hpp"
#include "plan/doubts.hpp"
#include "plan/plan.hpp"
#include "plan/plan_line.hpp"
#include "plan/plan_words.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "skein/time/integrator.hpp"

#include <fmt/format.h>

namespace skein {

namespace {

/// Combined effect of loads on the step: the sum of their rates or stiffnesses, over the inertia that kicks feel, and
/// the load that has the largest.
struct Together {
    double sum = 0;
    DragRate largest;
    std::string_view label;
};
Together together(const LoadPlan& plan, const GroupPlan& p, const RodGroup& group,
                  DragRate (Load::*of)(const RodGroup&) const) {
    Together all;
    for (const std::size_t i : nth(plan.of_group, group.id())) {
        const Load& load = plan.loads[i];
        const DragRate one = (load.*of)(group);
        if (one.value > all.largest.value) {
            all.largest = one;
            all.label = load.label();
        }
        all.sum += one.value / p.effective_inertia();
    }
    return all;
}

void limit_by_drag(const LoadPlan& plan, GroupPlan& p, const RodGroup& group, const Scheme& scheme) {
    const Together drag = together(plan, p, group, &Load::largest_rate);
    const double fastest = p.limits.front().dt, half = 0.5 * fastest * scheme.stability * drag.sum / scheme.drag;
    p.limited_by_loads |= drag.sum > 0;
    p.limit(drag.label, slowed(fastest, half), drag.largest.element);
}

void limit_by_stiffness(const LoadPlan& plan, GroupPlan& p, const RodGroup& group) {
    const Together stiff = together(plan, p, group, &Load::largest_stiffness);
    p.limited_by_loads |= stiff.sum > 0;
    p.limit(stiff.label, stiffened(2 / p.limits.front().dt, stiff.sum), stiff.largest.element);
}

/// Doubts about the tables of loads.
std::vector<std::string> doubts_of(const PlanInput& input, std::span<const Load> loads) {
    std::vector<std::string> found = formula_doubts(input.scene);
    const auto append = [&](std::vector<std::string> more) {
        for (std::string& doubt : more) found.push_back(std::move(doubt));
    };
    ScaleDoubts scales(input.scene.time.duration, input.groups);
    for (std::size_t i = 0; i < input.scene.loads.size(); ++i) {
        LoadSpec copy = input.scene.loads[i]; // fields() hands out references to change
        scales.look_at(fmt::format("load.{}", i), [&](FieldVisitor& f) { copy.fields(f); });
    }
    append(scales.take());
    for (std::size_t i = 0; i < loads.size(); ++i)
        if (const auto* formula = loads[i].get_if<FormulaLoad>(); formula && formula->couple_answers())
            found.push_back(fmt::format(
                "load.{}: its couple changes with places or velocities, which the limit of the step does not "
                "count: a run that breaks under it may need a shorter one",
                i));
    append(plane_doubts(input.scene, input.groups));
    return found;
}

class PlannedLoads final : public PhysicsPlan, public LoadPlan {
public:
    explicit PlannedLoads(const PlanInput& input) : damping_(input.scene.damping) {
        loads = input.loads;
        for (const LoadSpec& load : input.scene.loads)
            sources.push_back(load.source.empty() ? input.scene.file : load.source);
        for (const RodGroup& group : input.groups) {
            std::vector<std::size_t>& numbers = of_group.emplace_back();
            for (std::size_t i = 0; i < loads.size(); ++i)
                if (names_group(input.scene.loads[i].rods, group.name()) && loads[i].acts_on(group.spec()))
                    numbers.push_back(i);
        }
        doubts_ = doubts_of(input, loads);
    }

    std::string summary(const Plan&) const override {
        return loads.empty() ? "" : counted(static_cast<std::int64_t>(loads.size()), "load");
    }
    std::vector<PlanLine> describe(const Plan& p) const override {
        std::vector<PlanLine> lines;
        for (std::size_t g = 0; g < of_group.size(); ++g)
            for (const std::size_t i : of_group[g])
                if (const auto* plane = loads[i].get_if<PlaneFriction>())
                    lines.push_back({"plane",
                                     fmt::format("elements of '{}' touch it up to a gap of {:.3g} m; elements that "
                                                 "slip slower than {:.3g} m/s are held",
                                                 p.groups[g].name, plane->tolerance, plane->slip_speed),
                                     "",
                                     {}});
        return lines;
    }
    std::vector<std::string> notes(const Plan&, std::span<const RodGroup>) const override { return doubts_; }

    void act_on(GroupPlan& p, const RodGroup& group) const override {
        if (!group.places().from_file()) // else each rank knows some of the rods: fault_of_read_rods
            if (const std::string fault = fault_at_start(group); !fault.empty()) throw InputError(fault);
        for (const DampingSpec& d : damping_)
            if (names_group(d.rods, group.name())) p.damping.push_back(d.damping);
    }
    void add_passes(GroupPlan& p, const RodGroup& group) const override {
        for (const std::size_t i : nth(of_group, group.id())) {
            const Load& load = loads[i];
            const std::string family =
                load.keeps_tables_of_group() ? fmt::format("{} in {}", i, group.id()) : fmt::format("{}", i);
            p.program.add(load.acts_last() ? PassPlace::last_loads : PassPlace::loads, pass::ApplyLoad{load, family});
        }
    }
    void tighten_limits(GroupPlan& p, const RodGroup& group, const Scheme& scheme) const override {
        limit_by_stiffness(*this, p, group);
        limit_by_drag(*this, p, group, scheme);
    }

private:
    std::vector<DampingSpec> damping_;
    std::vector<std::string> doubts_;
};

} // namespace

std::string LoadPlan::fault_at_start(const RodGroup& group) const {
    for (const std::size_t i : nth(of_group, group.id()))
        if (const std::string fault = loads[i].fault_at_start(group); !fault.empty())
            return fmt::format("{}: {}", sources[i], fault);
    return {};
}

std::string fault_of_read_rods(const Plan& plan, std::span<const RodGroup> groups) {
    const auto* loads = plan.find<LoadPlan>();
    for (const RodGroup& group : groups)
        if (loads && group.places().from_file())
            if (std::string fault = loads->fault_at_start(group); !fault.empty()) return fault;
    return {};
}

void LoadTables::resolve(SceneSpec& scene, std::span<const RodGroup> groups) {
    scene = with_plane_numbers(std::move(scene), groups);
}

bool LoadTables::look_at_whole_rods(const SceneSpec& scene, const RodSpec& rods) {
    const bool filtered = std::any_of(scene.damping.begin(), scene.damping.end(), [&](const DampingSpec& d) {
        return is_filter(d.damping) && names_group(d.rods, rods.name);
    });
    return filtered || std::any_of(scene.loads.begin(), scene.loads.end(), [&](const LoadSpec& l) {
               return names_group(l.rods, rods.name) &&
                      (l.load.keeps_tables_of_group() || l.load.needs_whole_rods() || l.load.limits_step());
           });
}

void LoadTables::plan(const PlanInput& input, PlannedPhysics& out) {
    if (!input.groups.empty()) out.add<PlannedLoads>(input);
}

} // namespace skein
