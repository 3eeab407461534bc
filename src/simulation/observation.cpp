#include "simulation/observation.hpp"

#include "diagnostics/energy_audit.hpp"
#include "diagnostics/observables.hpp"
#include "loads/gravity.hpp"
#include "physics/audit/audit_plan.hpp"
#include "physics/contact/contact_interaction.hpp"
#include "physics/contact/contact_plan.hpp"
#include "physics/fluid/fluid_plan.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace skein {

Observation::Observation(const World& world, const SceneSpec& scene)
    : world_(world), sets_{scene.output.observes("angular_momentum"), scene.output.observes("curvature"),
                           scene.output.observes("knots"), scene.output.observes("order")},
      probes_(scene.probes), staged_(!scene.stages.empty()),
      gravity_acts_(std::any_of(scene.loads.begin(), scene.loads.end(), [&](const LoadSpec& one) {
          return !scene.stages.empty() && one.rods.empty() && one.load.get_if<Gravity>();
      })) {}

std::vector<std::string> Observation::names() const {
    if (world_.groups.empty()) return names_of_figures(world_.interactions());
    auto all = observable_names(sets_);
    if (world_.plan.has<AuditPlan>()) all.insert(all.end(), std::begin(audit_names), std::end(audit_names));
    if (books_fluid()) all.emplace_back(audit_fluid_name);
    if (books_steps()) all.emplace_back(audit_steps_name);
    if (world_.plan.has<AuditPlan>() && staged_) all.emplace_back("stage_work[J]");
    for (std::string& name : names_of_figures(world_.interactions())) all.push_back(std::move(name));
    const auto* touch = world_.plan.find<TouchPlan>();
    const bool falls = touch && (touch->gravity || gravity_acts_);
    if (falls) all.emplace_back("potential[J]");
    if (falls && sets_.order) all.emplace_back("agitation[-]");
    for (std::string& name : probe_names(probes_)) all.push_back(std::move(name));
    return all;
}

std::vector<double> Observation::values() const {
    const Plan& plan = world_.plan;
    const std::optional<double>& solved = world_.solved();
    const Sample at{solved.value_or(world_.clock.time()), solved ? 0 : world_.clock.lag(), solved.has_value()};
    if (world_.groups.empty()) return values_of_figures(world_.comm, world_.interactions(), at);
    auto values = observe(world_.comm, world_.threads, world_.groups, world_.rods(), at.time, at.lag, sets_);
    if (plan.has<AuditPlan>()) {
        const EnergyAudit a = audit(values, at.lag);
        std::vector<double> works{a.loads, a.walls, a.dissipated, a.defect(*audited_from())};
        if (books_fluid()) works.push_back(a.fluid);
        if (books_steps()) works.push_back(a.numerical);
        if (staged_) works.push_back(stage_work());
        if (at.solved) works.assign(works.size(), std::numeric_limits<double>::quiet_NaN()); // sums over steps
        values.insert(values.end(), works.begin(), works.end());
    }
    const Vec3d centre{values[observed_centre], values[observed_centre + 1], values[observed_centre + 2]};
    for (const double x : values_of_figures(world_.comm, world_.interactions(), at)) values.push_back(x);
    const auto* touch = plan.find<TouchPlan>();
    if (touch && (touch->gravity || gravity_acts_)) {
        const Vec3d gravity = touch->gravity.value_or(Vec3d{0, 0, 0});
        const double weight = norm(gravity) * touch->mass_radius;
        values.push_back(-touch->mass * dot(gravity, centre));
        if (sets_.order) values.push_back(weight > 0 ? values[observed_translation] / weight : 0);
    }
    for (const double x : probe_values(world_.comm, world_.groups, world_.rods(), at.lag, probes_)) values.push_back(x);
    return values;
}

const std::vector<double>& Observation::sample() {
    if (step_ != world_.clock.done()) {
        last_ = values();
        step_ = world_.clock.done();
    }
    return last_;
}

bool Observation::finite() const { // a copy half a step on may fail before the state itself
    return std::isfinite(world_.groups.empty() ? last_.front() : observed_energy(last_));
}

double Observation::speed() const { return last_[observed_speed]; }
double Observation::turn() const { return world_.groups.empty() ? 0 : last_[observed_turn_per_cell]; }
double Observation::strain() const { return world_.groups.empty() ? 0 : last_[observed_axial_strain]; }

void Observation::begin_audit(World& world, std::optional<double> audited_from) {
    audited_from_ = audited_from;
    if (audited_from_) return;
    const Clock& clock = world.clock;
    if (ContactInteraction* contacts = contacts_of(world.interactions())) contacts->begin_audit(clock.lag());
    audited_from_ =
        observed_energy(observe(world.comm, world.threads, world.groups, world.rods(), clock.time(), clock.lag()));
    for (std::size_t i = 0; i < world.rods().local().size(); ++i)
        world.rods().set_budget(i, {}); // a damaged checkpoint may have left its own
}

EnergyAudit Observation::audit(std::span<const double> observed, double lag) const {
    EnergyAudit a = audit_scene(world_.comm, world_.rods(), observed_energy(observed));
    if (const ContactInteraction* contacts = contacts_of(world_.interactions())) a.contacts = contacts->booked(lag);
    return a;
}

EnergyAudit Observation::audit() const {
    const Clock& clock = world_.clock;
    return audit(observe(world_.comm, world_.threads, world_.groups, world_.rods(), clock.time(), clock.lag()),
                 clock.lag());
}

void Observation::leave_stage() {
    if (!audited_from_) return;
    left_ = audit();
    left_defect_ = left_.defect(*audited_from());
    if (given_) {
        left_defect_ = (*given_)[0];
        left_.contacts = (*given_)[1];
        given_.reset();
    }
    stage_work_ = stage_work();
}

std::array<double, 2> Observation::left() const {
    if (!audited_from_) return {};
    const EnergyAudit now = audit();
    return {now.defect(*audited_from()), now.contacts};
}

void Observation::enter_stage(World& world) {
    step_ = -1; // the last sample is of the stage before
    if (!audited_from_) return;
    const Clock& clock = world.clock;
    const EnergyAudit now = audit_scene(
        world.comm, world.rods(),
        observed_energy(observe(world.comm, world.threads, world.groups, world.rods(), clock.time(), clock.lag())));
    stage_work_ += now.energy - left_.energy;
    *audited_from_ = now.energy - now.loads - now.fluid - now.walls + now.dissipated - left_defect_;
    left_contacts_ = left_.contacts;
    if (ContactInteraction* contacts = contacts_of(world.interactions())) contacts->begin_audit(clock.lag());
}

bool Observation::books_fluid() const {
    const auto* fluid = world_.plan.find<FluidPlan>();
    return world_.plan.has<AuditPlan>() && fluid && fluid->two_way();
}

bool Observation::books_steps() const {
    const auto* audit = world_.plan.find<AuditPlan>();
    return audit && audit->by_steps;
}

double Observation::stage_work() const {
    const ContactInteraction* contacts = contacts_of(world_.interactions());
    if (!contacts || !left_contacts_ || contacts->audit_begins()) return stage_work_;
    return stage_work_ + (contacts->booked_at_start() - *left_contacts_);
}

std::optional<double> Observation::audited_from() const {
    const ContactInteraction* contacts = contacts_of(world_.interactions());
    return audited_from_ && contacts ? *audited_from_ + contacts->booked_at_start() : audited_from_;
}

} // namespace skein
