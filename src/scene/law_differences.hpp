// How far rod laws lie apart where a rod is strongly curved.                                                theory.md
// (11a)
#pragma once

#include "skein/rod/rod_group.hpp"

#include <optional>
#include <string>

namespace skein {

/// What to tell of a group whose curvature at rest or at the start makes r kappa larger than 5 % somewhere: what its
/// rods lengthen by with each law. Nothing of others, of rods with shapes of their own, nor of the published law.
std::optional<std::string> law_differences(const RodGroup& group);

} // namespace skein
