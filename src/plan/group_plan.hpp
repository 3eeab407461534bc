// The plan of a group: its kick, passes and limits.
#pragma once

#include "plan/plan.hpp"

#include <memory>
#include <span>
#include <vector>

namespace skein {

using PhysicsPlans = std::vector<std::shared_ptr<PhysicsPlan>>;

/// `acts_between`: some physics acts between rods. Throws InputError where rods have sizes of their own that a pass
/// cannot take.
GroupPlan plan_group(const TimeSpec& time, const RodGroup& group, const PhysicsPlans& physics, bool acts_between);

/// Numbers the families of groups, which have the same passes and may share tiles along; returns how many there are.
int find_families(std::span<GroupPlan> groups);

} // namespace skein
