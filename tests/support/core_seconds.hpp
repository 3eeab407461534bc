// Processor time.
#pragma once

#include <ctime>

namespace skein::test {

/// Processor time of all threads so far, s: what other programs disturb least.
inline double core_seconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

} // namespace skein::test
