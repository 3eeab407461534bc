// Entry to bodies at rest of one level.
#pragma once

#include "kernels/static_rods.hpp"
#include "kernels/surroundings.hpp"
#include "plan/plan.hpp"

#include <memory>
#include <span>

namespace skein {

/// `groups` must outlive them.
std::unique_ptr<StaticRods> make_static_rods_at(const Plan& plan, std::span<const RodGroup> groups,
                                                std::span<const LocalRod> owned, const Surroundings& around);

} // namespace skein
