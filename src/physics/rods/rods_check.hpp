// Contradictions within one group of rods.
#pragma once

#include "skein/core/objections.hpp"
#include "skein/rod/rod_spec.hpp"

namespace skein {

/// `objections`: of the group's table, [[rods]].
void check_rods(const RodSpec& rods, Objections& objections);

} // namespace skein
