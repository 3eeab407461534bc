#include "coupling/interaction.hpp"
#include "immersion/fluid_loads.hpp"
#include "kernels/physics_passes.hpp"
#include "kernels/surroundings.hpp"
#include "physics/fluid/fluid_doubts.hpp"
#include "physics/fluid/fluid_interaction.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "physics/fluid/fluid_plan_text.hpp"
#include "physics/fluid/fluid_pressure.hpp"
#include "physics/fluid/fluid_steps.hpp"
#include "physics/fluid/stated_speeds.hpp"
#include "physics/plan_input.hpp"
#include "plan/plan.hpp"
#include "plan/plan_line.hpp"
#include "plan/plan_steps.hpp"
#include "plan/plan_words.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace skein {

namespace {

/// Bytes of a fluid's velocities and pressure, and of rates if the scheme continues with them.
double kept_bytes(const FlowConstants& fluid) {
    return (keeps_rates(fluid.scheme) ? 7 : 4) * sizeof(double) * static_cast<double>(fluid.grid.count());
}

std::string meeting_text(const FluidPlan& fluid, const Plan& p) {
    return fmt::format(
        "every {} steps of rods, {:.4g} s: a step of the fluid, or up to {} where it has to be shorter{}",
        p.events_every, static_cast<double>(p.events_every) * p.dt, fluid.most_parts(),
        fluid.largest_slip > 0 ? fmt::format(", as for slips above {:g} of the speed", fluid.largest_slip) : "");
}

class PlannedFluid final : public PhysicsPlan, public FluidPlan, public StartsInteraction, public SharesWithPasses {
public:
    explicit PlannedFluid(const PlanInput& input) : FluidPlan(plan_fluid(input)) {
        doubts_ = fluid_doubts(*this, input.groups);
        for (std::string& doubt : abrupt_starts(input.scene, input.groups, input.loads))
            doubts_.push_back(std::move(doubt));
    }

    std::string summary(const Plan& p) const override {
        const auto& cells = constants.grid.cells;
        const bool same =
            constants.pressure == PressureMethod::direct && constants.exchange == ColumnExchange::transposes;
        return fmt::format("fluid of {} x {} x {} cells, {:.0f} steps{}{}", cells[0], cells[1], cells[2],
                           steps(p.steps, p.dt), speed.value > 0 ? "" : " at least",
                           same ? "" : "; bits depend on the number of ranks");
    }
    std::vector<PlanLine> describe(const Plan& p) const override {
        const Machine& machine = p.machine;
        const int cores = machine.ranks * std::min(machine.threads, machine.cores);
        std::vector<PlanLine> lines = {
            {"fluid", fluid_text(*this), "fluid", fluid_json(*this, p.steps, p.dt, machine.ranks)},
            {"  driven by", drive_text(*this), "", {}},
            {"  pressure", pressure_text(*this, machine.ranks), "", {}},
            {"  sent", machine.ranks > 1 ? sent_text(*this, machine.ranks) : "", "", {}}};
        for (const Obstacle& o : obstacles) lines.push_back({"  obstacle", obstacle_text(o, *this), "", {}});
        for (const RodsInFluid& r : rods)
            lines.push_back({r.body ? "  bodies" : "  rods", rods_in_fluid_text(r, *this), "", {}});
        lines.push_back({"  dt", rods.empty() ? "divides steps of the run as its velocities want" : "", "", {}});
        lines.push_back({"  meets rods", p.events_every > 1 ? meeting_text(*this, p) : "", "", {}});
        for (const FluidOutput& o : outputs)
            lines.push_back({"  output", output_text(o, constants.grid, p.steps, p.dt), "", {}});
        for (const FluidProbeSpec& probe : probes) lines.push_back({"  probe", probe_text(probe), "", {}});
        lines.push_back({"  loads", single_loads_text(single_loads), "", {}});
        lines.push_back({"  power", measures_power ? "of bodies at their surfaces, in each stage" : "", "", {}});
        lines.push_back({"  steps", fluid_steps_text(*this, p.steps, p.dt), "", {}});
        lines.push_back({"  memory", fmt::format("{:.0f} B per cell", bytes_per_cell(machine.ranks)), "", {}});
        lines.push_back({"  cost", fluid_cost_text(*this, p.steps, p.dt, cores, machine.cores_per_node), "", {}});
        return lines;
    }
    bool describes(std::string_view output) const override { return output == "fields"; }
    std::vector<std::string> notes(const Plan& p, std::span<const RodGroup>) const override {
        std::vector<std::string> all = doubts_;
        if (std::string fault = unshared(constants, p.machine.ranks); !fault.empty()) all.push_back(std::move(fault));
        return all;
    }

    void act_on(GroupPlan& p, const RodGroup& group) const override {
        if (two_way()) p.inertia = inertia_of(group)->least_effective();
    }
    void add_passes(GroupPlan& p, const RodGroup& group) const override {
        if (two_way()) p.program.add(PassPlace::medium, pass::FeelFluid{inertia_of(group)});
    }
    Coupling coupling() const override { return Coupling::at_events; }

    bool sets_step(Plan& plan, const CoreTables& scene) override {
        if (!rods.empty()) return false;
        choose_step_of_fluid(*this, plan, scene);
        count_output_steps(plan);
        return true;
    }
    bool divides_interval(Plan& plan, const CoreTables& scene, double longest) override {
        divide_step_of_fluid(*this, plan, scene, longest);
        plan.events_every = std::max<std::int64_t>(1, every);
        count_output_steps(plan);
        return true;
    }
    void take_given_step(Plan& plan, const CoreTables& scene) override {
        count_steps_in_fluid(*this, plan, scene);
        plan.events_every = std::max<std::int64_t>(1, every);
        count_output_steps(plan);
    }
    std::vector<std::pair<std::string, double>> output_intervals() const override {
        std::vector<std::pair<std::string, double>> intervals;
        for (const FluidOutput& output : outputs)
            if (!output.name.empty()) intervals.emplace_back(output.name, output.interval); // others are output.fields
        return intervals;
    }

    void add_bytes(Plan& plan, std::span<const RodGroup> groups) override {
        const FluidGrid& grid = constants.grid;
        const auto cells = static_cast<double>(grid.count());
        plan.copy_bytes += kept_bytes(constants) + (writes_pressure(*this) ? sizeof(double) * cells : 0);
        for (const RodGroup& group : groups)
            if (two_way())
                plan.state_bytes += static_cast<double>(group.count() * group.slots()) * FluidLoads::bytes_per_slot;
        plan.state_bytes += cells * bytes_per_cell(plan.machine.ranks);
        for (const FluidOutput& output : outputs)
            (output.kind == FluidOutputKind::blocks ? plan.output_bytes_most : plan.output_bytes) +=
                plan.frames(output.every) * output.most_bytes(grid);
    }
    double core_seconds(const Plan& plan) const override { return steps(plan.steps, plan.dt) * step_seconds(); }

    void share(Surroundings& around, std::span<const RodGroup> groups, std::span<const LocalRod> owned) const override {
        if (two_way()) around.fluid = std::make_shared<FluidLoads>(groups, owned);
    }
    std::unique_ptr<Interaction> start(const InteractionParts& parts) const override {
        return std::make_unique<FluidInteraction>(parts, *this);
    }

private:
    /// Inertia of rods that are alike. Plans of rods of own sizes take each kind in turn, and the least inertia.
    const std::shared_ptr<const InertiaInFluid>& inertia_of(const RodGroup& group) const {
        return kinds->of(group, 0).inertia;
    }
    void count_output_steps(const Plan& plan) {
        for (FluidOutput& output : outputs) output.every = whole_steps(output.interval, plan);
    }

    std::vector<std::string> doubts_;
};

} // namespace

bool FluidTables::look_at_whole_rods(const SceneSpec& scene, const RodSpec&) { return scene.fluid.has_value(); }

void FluidTables::plan(const PlanInput& input, PlannedPhysics& out) {
    if (input.scene.fluid) out.add<PlannedFluid>(input);
}

} // namespace skein
