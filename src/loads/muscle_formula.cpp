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
        objections.add("", "muscles have three formulas, of 'moment' [N m] or of 'curvature' [1/m]");
    if (!curvature.empty() && frame == LoadFrame::lab)
        objections.add("frame", "a rest curvature is about body axes: frame = \"body\", or a 'moment'");
    if (reading_) reading_->tell(objections);
    if (moment_.given && (moment_.program.changes & with_state) != 0)
        objections.add(
            key(),
            fmt::format(
                "'{}': muscles know no lab places and velocities; it may change with t, s, L, rod, X, Y, Z alone",
                key()));
}

std::string MuscleFormula::fault_at_start(const RodGroup& group) const {
    return reading_ ? reading_->fault(key(), group, nodes_, false) : std::string();
}

} // namespace skein
