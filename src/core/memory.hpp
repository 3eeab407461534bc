// Memory that is there to be taken.
#pragma once

#include <cstdint>

namespace skein {

/// Bytes that this process may still take: what the machine, its control group (a job's share of a node) and `ulimit
/// -v` leave, whichever is least. Infinite where nothing says.
double free_memory();

} // namespace skein
