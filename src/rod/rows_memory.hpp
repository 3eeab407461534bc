// Check that memory suffices for the rows of a file of rods.
#pragma once

#include "skein/rod/rod_group.hpp"

#include <cstdint>

namespace skein {

/// Throws InputError naming the file, the number of rows, the memory that they need and the free memory, where it is
/// too little.
void require_memory_of_rows(const RodGroup& group, std::int64_t rows);

} // namespace skein
