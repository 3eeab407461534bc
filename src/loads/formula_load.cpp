#include "loads/formula_load.hpp"

#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"

namespace skein {

void FormulaLoad::fields(FieldVisitor& f) {
    f.visit({.name = "force", .text = "three formulas: force, lab frame [N/m], or in the unit of `per` and `at`"},
            force);
    f.visit({.name = "couple", .text = "three formulas: couple [N m/m], or in the unit of `per` and `at`"}, couple);
    f.choice({.name = "per",
              .text = "reference of the formulas: a metre of rest length, a kilogram [m/s^2], or the whole rod, "
                      "distributed by length [N]"},
             per, formula_per_names);
    f.choice(
        {.name = "at", .text = "place of the load: the whole rod, or its first or last node (or element) alone [N]"},
        at, formula_at_names);
    f.choice({.name = "frame", .text = "axes of `couple`: lab, or d1 d2 d3 of each element"}, frame, load_frame_names);
}

void FormulaLoad::use(const FormulaScope& scope) {
    reading_ = nullptr;
    if (!faults(scope).empty()) return; // faults of names are reported elsewhere
    FormulaReading reading(scope);
    const bool whole = at != FormulaAt::rod || per == FormulaPer::rod, by_mass = per == FormulaPer::mass;
    force_nodes_ = reading.read("force", force, whole ? "N" : by_mass ? "m/s^2" : "N/m");
    couple_nodes_ = reading.read("couple", couple, whole ? "N m" : by_mass ? "m^2/s^2" : "N");
    force_ = reading.compile("force", force_nodes_);
    couple_ = reading.compile("couple", couple_nodes_);
    reading_ = std::make_shared<FormulaReading>(std::move(reading));
}

void FormulaLoad::check(RodSpecs groups, Objections& objections) const {
    if (reading_) reading_->add_faults(objections);
    if (force.empty() && couple.empty()) objections.add("", "a load of kind formula needs 'force' or 'couple'");
    if (at != FormulaAt::rod) objections.unused({"per"}, "for a load at one end");
    if (couple.empty()) objections.unused({"frame"}, "without 'couple'");
    if (at == FormulaAt::rod) return;
    for (const RodSpec* rods : groups)
        if (rods->shape.closed)
            objections.add("at", "a load at an end needs rods with two ends, but those of group '" + rods->name +
                                     "' are rings");
}

std::string FormulaLoad::fault_at_start(const RodGroup& group) const {
    if (!reading_) return {};
    const std::string fault = reading_->fault("force", group, force_nodes_, false);
    return fault.empty() ? reading_->fault("couple", group, couple_nodes_, true) : fault;
}

double FormulaLoad::weight_over_mass(const RodGroup& group, int node) const {
    const std::size_t i = to_index(node);
    const double mass = group.node_mass[i];
    if (mass == 0) return 0; // a ring's last node is its first
    if (at != FormulaAt::rod) return node == (at == FormulaAt::start ? 0 : group.elements()) ? 1 / mass : 0;
    if (per == FormulaPer::mass) return 1;
    return group.node_length[i] / mass / (per == FormulaPer::rod ? group.spec().shape.length : 1.0);
}

DragRate FormulaLoad::largest_rate(const RodGroup& group) const {
    if (!reading_) return {};
    return steepest(*reading_, group, force_nodes_, Variable::vx,
                    [&](int node) { return weight_over_mass(group, node); });
}

DragRate FormulaLoad::largest_stiffness(const RodGroup& group) const {
    if (!reading_) return {};
    return steepest(*reading_, group, force_nodes_, Variable::x,
                    [&](int node) { return weight_over_mass(group, node); });
}

} // namespace skein
