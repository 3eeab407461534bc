#include "loads/muscle_formula.hpp"

#include "skein/rod/rod_group.hpp"

#include <fmt/format.h>

namespace skein {

void MuscleFormula::use(const FormulaScope& scope) {
    reading_ = nullptr;
    if (!faults(scope).empty()) return; // faults of names are reported elsewhere
    FormulaReading reading(scope);
    nodes_ = curvature.empty() ? reading.read("moment", moment, "N m") : reading.read("curvature", curvature, "1/m");
    moment_ = reading.compile(key(), nodes_);
    reading_ = std::make_shared<FormulaReading>(std::move(reading));
}

void MuscleFormula::check(RodSpecs, Objections& objections) const {
    if (moment.empty() == curvature.empty())
        objections.add("", "muscles need three formulas: 'moment' [N m] or 'curvature' [1/m]");
    if (!curvature.empty() && frame == LoadFrame::lab)
        objections.add("frame", "a 'curvature' refers to body axes: set frame = \"body\", or give a 'moment'");
    if (reading_) reading_->add_faults(objections);
    if (moment_.given && (moment_.program.changes & with_state) != 0)
        objections.add(
            key(),
            fmt::format(
                "'{}' of muscles may change with t, s, L, rod, X, Y, Z alone, not with lab places and velocities",
                key()));
}

std::string MuscleFormula::fault_at_start(const RodGroup& group) const {
    return reading_ ? reading_->fault(key(), group, nodes_, false) : std::string();
}

} // namespace skein
