// Free memory of this process.
#pragma once

#include <cstdint>

namespace skein {

/// Bytes that this process may still allocate: the least of three limits. They are those of the machine, of its control
/// group (a job's share of a node) and of `ulimit -v`. Infinite where there is no limit.
double free_memory();

} // namespace skein
