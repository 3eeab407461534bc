// Contradictions within a [[bodies]].
#pragma once

#include "skein/core/objections.hpp"
#include "skein/rod/rod_spec.hpp"

namespace skein {

void check_body(const RodSpec& spec, Objections& objections);

} // namespace skein
