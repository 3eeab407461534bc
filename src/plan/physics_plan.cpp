#include "plan/physics_plan.hpp"

#include "plan/plan_line.hpp"

namespace skein {

std::vector<PlanLine> PhysicsPlan::describe(const Plan&) const { return {}; }

} // namespace skein
