// The plan of a group: its kick, passes and limits.
#pragma once

#include "plan/plan.hpp"

#include <memory>
#include <span>
#include <vector>

namespace skein {

using PhysicsPlans = std::vector<std::shared_ptr<PhysicsPlan>>;

/// `acts_between`: some physics acts between rods.
GroupPlan plan_group(const TimeSpec& time, const RodGroup& group, const PhysicsPlans& physics, bool acts_between);

/// The plan of one rod of a group whose rods have sizes of their own, RodGroup::kind.
GroupPlan plan_of_rod(const Plan& plan, const RodGroup& rod);

/// Numbers the families of groups, which have the same passes and may share tiles along; returns how many there are.
int find_families(std::span<GroupPlan> groups);

} // namespace skein
