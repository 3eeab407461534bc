#include "core/field_looker.hpp"
#include "loads/formula_load.hpp"
#include "loads/magnetic_formula.hpp"
#include "loads/muscle_formula.hpp"
#include "physics/loads/loads_with_formulas.hpp"
#include "physics/scene_spec.hpp"
#include "physics/table_objections.hpp"

#include <fmt/format.h>

namespace skein {

namespace {

/// The first time that a load gives, in seconds: what has one is a function of time.
class TimesOf final : public FieldLooker {
public:
    using FieldLooker::visit;
    std::string name; ///< empty: it has none

    void visit(const Field& field, double& value) override {
        if (field.unit == "s" && value != 0 && name.empty()) name = field.name;
    }
};

constexpr const char* chosen = "chooses inertia: leave it out";

void rods(const RodSpec& rods, Objections& group) {
    const auto refuse = [&](bool has, std::string_view key, std::string_view message) {
        if (has) group.add(key, fmt::format("time.relax {}", message));
    };
    refuse(rods.body.has_value(), "",
           "is not for rigid bodies, which have no stiffness of their own to come to rest by: leave it out, and damp "
           "their motion");
    refuse(rods.material.law == Law::elastica, "material.law", "needs a law with an energy, and \"elastica\" has none");
    refuse(rods.material.rotary_inertia_scale != 1, "material.rotary_inertia_scale", chosen);
    refuse(rods.material.rotary_inertia_for_dt != 0, "material.rotary_inertia_for_dt", chosen);
    refuse(rods.has_motions(), "",
           "is not for ends that are moved: a motion is a function of time, and its steps are none of time");
    refuse(!zero(rods.shape.velocity) || !zero(rods.shape.angular_velocity) || !zero(rods.shape.element_spin), "shape",
           "begins at rest: give no velocities");
}

/// True if a formula of the load names `v`.
bool by_formula(const Load& load, Variable v) {
    const auto* formula = load.get_if<FormulaLoad>();
    const auto* field = load.get_if<MagneticFormula>();
    const auto* muscles = load.get_if<MuscleFormula>();
    return (formula && formula->depends_on(v)) || (field && field->depends_on(v)) ||
           (muscles && muscles->depends_on(v));
}

void contact_law(const ContactLaw& law, Objections& table) {
    if (law.soft_until > 0) table.add("soft_until", "time.relax needs contacts that do not change with time");
    if (law.friction_from > 0) table.add("friction_from", "time.relax needs contacts that do not change with time");
    if (slips_always(law.friction))
        table.add("friction", "time.relax needs friction that holds what is at rest: \"memory\", or none");
}

void check_joint(const JointSpec& spec, Objections& table) {
    if (spec.has_motor())
        table.add("motor",
                  "time.relax has no time that a motor could follow: 'spring' and 'spring_rest' hold the axis");
    if (spec.events.from > 0 || spec.events.until > 0)
        table.add("", "time.relax has no time for 'from' and 'until': leave them out, or give 'stages'");
    if (spec.events.break_strain > 0)
        table.add("break_strain", "time.relax passes strains that no motion has: leave it out");
}

} // namespace

void RelaxationTables::check(const SceneSpec& scene, Objections& objections) {
    const TimeSpec& time = scene.time;
    TableObjections of_time(objections, "time");
    if (!time.relax) {
        of_time.unused({"relax_tolerance"}, "without relax = true");
        return;
    }
    of_time.unused({"dt", "divide", "safety", "e_min", "integrator", "damping", "rest_speed", "force_dt"},
                   "with relax = true, which chooses steps and damping, and ends when rods have settled");
    if (time.duration < 1) of_time.add("duration", "with relax = true 'duration' counts steps of 1 s: give at least 1");
    if (!scene.start.from.empty())
        objections.add("start.from", "time.relax begins with the shape of the scene, at rest");
    if (scene.output.audit)
        objections.add("output.audit", "there is no audit with time.relax: inertia is not that of the rods");
    for (std::size_t i = 0; i < scene.rods.size(); ++i) {
        TableObjections group(objections, path_of_group(scene, i));
        rods(scene.rods[i], group);
    }
    for (std::size_t i = 0; i < scene.damping.size(); ++i)
        objections.add(fmt::format("damping.{}", i), "time.relax chooses damping: give none");
    const std::vector<Load> loads = loads_with_formulas(scene);
    for (std::size_t i = 0; i < loads.size(); ++i) {
        const std::string table = fmt::format("load.{}", i);
        const Load& load = loads[i];
        TimesOf times;
        Load(load).fields(times);
        if (!times.name.empty())
            objections.add(table,
                           fmt::format("time.relax needs loads that do not change with time, and this one has '{}' [s]",
                                       times.name));
        if (by_formula(load, Variable::t))
            objections.add(table,
                           "time.relax needs loads that do not change with time, and a formula of this one names 't'");
        const bool answers =
            by_formula(load, Variable::vx) || by_formula(load, Variable::vy) || by_formula(load, Variable::vz);
        if (load.acts_last() || answers)
            objections.add(
                table, fmt::format("a load of kind \"{}\" answers motion, which time.relax has none of", load.kind()));
    }
    for (std::size_t i = 0; i < scene.joints.size(); ++i) {
        TableObjections table(objections, fmt::format("joint.{}", i));
        check_joint(scene.joints[i], table);
    }
    const auto law_of = [&](const std::string& table, const ContactLaw& law) {
        TableObjections of_law(objections, table);
        contact_law(law, of_law);
    };
    if (scene.contact) law_of("contact", scene.contact->law);
    for (std::size_t i = 0; i < scene.contact_pairs.size(); ++i)
        law_of(fmt::format("contact_pair.{}", i), scene.contact_pairs[i].law);
    for (std::size_t i = 0; i < scene.walls.size(); ++i) {
        const Wall& wall = scene.walls[i];
        const std::string table = fmt::format("wall.{}", i);
        law_of(table, wall.law);
        if (wall.servo.drives() || wall.moves_steadily())
            objections.add(table, "time.relax is not for walls that move");
    }
}

} // namespace skein
