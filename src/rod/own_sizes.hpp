// Sizes of one rod of a file, in the form of a scene.
#pragma once

#include "skein/placement/places.hpp"
#include "skein/rod/rod_spec.hpp"

namespace skein {

/// Puts length, radius and shape of rod i of `places` into `own`, a copy of `spec`.
void put_sizes(const Places& places, const RodSpec& spec, std::int64_t i, RodSpec& own);

} // namespace skein
