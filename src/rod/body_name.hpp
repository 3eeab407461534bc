// Names of rods and bodies in messages.
#pragma once

#include "skein/rod/rod_group.hpp"

#include <cstdint>
#include <span>
#include <string>

namespace skein {

/// "rod 3 of 'cilia'", by its number in the scene.
std::string name_of_body(std::span<const RodGroup> groups, std::int64_t gid);

} // namespace skein
