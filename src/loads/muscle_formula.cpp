#include "loads/muscle_formula.hpp"

#include "skein/rod/rod_group.hpp"

namespace skein {

void MuscleFormula::use(const FormulaScope& scope) {
    reading_ = nullptr;
    if (!faults(scope).empty()) return; // which are told where they stand
    FormulaReading reading(scope);
    nodes_ = reading.read("moment", moment, "N m");
    moment_ = reading.compile("moment", nodes_);
    reading_ = std::make_shared<FormulaReading>(std::move(reading));
}

void MuscleFormula::check(RodSpecs, Objections& objections) const {
    if (reading_) reading_->tell(objections);
    if (moment_.given && (moment_.program.changes & with_state) != 0)
        objections.add("moment",
                       "'moment': muscles know no lab places and velocities; it may change with t, s, L, rod, X, Y, Z alone");
}

std::string MuscleFormula::fault_at_start(const RodGroup& group) const {
    return reading_ ? reading_->fault("moment", group, nodes_, false) : std::string();
}

} // namespace skein
