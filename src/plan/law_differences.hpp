// Differences of rod laws for strongly curved rods.                                                theory.md
// (11a)
#pragma once

#include "skein/rod/rod_group.hpp"

#include <optional>
#include <string>

namespace skein {

/// Remark on a group whose curvature at rest or at the start makes r kappa larger than 5 % somewhere: what its
/// rods lengthen by with each law. Nothing of others, of rods with shapes of their own, nor of the published law.
std::optional<std::string> law_differences(const RodGroup& group);

} // namespace skein
