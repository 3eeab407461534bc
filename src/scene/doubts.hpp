// Numbers that are allowed and yet look like slips: so far from their neighbours that a unit or an exponent must be
// wrong.
#pragma once

#include "physics/contact/contact_estimate.hpp"
#include "skein/rod/rod_group.hpp"

#include <span>
#include <string>
#include <vector>

namespace skein {

/// One sentence each. Bounds are wide, some orders beyond what studies use: a warning that is often false is not read.
std::vector<std::string> doubts(const SceneSpec& scene, std::span<const RodGroup> groups, double dt);

/// Friction without memory whose slip speed is too low for the step under the forces that are expected. `laws`: null
/// where rods do not feel each other; `walls`: in the order of the estimate.
std::vector<std::string> slip_doubts(const ContactEstimate& estimate, const ContactLaws* laws,
                                     std::span<const Wall> walls, std::span<const RodGroup> groups, double dt);

} // namespace skein
