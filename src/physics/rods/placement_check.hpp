// Contradictions in where rods are placed.
#pragma once

#include "skein/core/objections.hpp"
#include "skein/rod/rod_spec.hpp"

namespace skein {

/// `objections`: of the group's table, [[rods]].
void check_placement(const RodSpec& rods, Objections& objections);

} // namespace skein
