// Rows of a file of rods that no memory is there for.
#pragma once

#include "skein/rod/rod_group.hpp"

#include <cstdint>

namespace skein {

/// Before so many rows of the group's file are read: throws InputError naming the file, the count, what they need and
/// what is free.
void require_memory_of_rows(const RodGroup& group, std::int64_t rows);

} // namespace skein
