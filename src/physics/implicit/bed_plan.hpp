// The plan of rods in contact that step implicitly.
#pragma once

namespace skein {

struct PlanInput;
class PlannedPhysics;

void plan_bed(const PlanInput& input, PlannedPhysics& out);

} // namespace skein
