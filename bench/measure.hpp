// Time and place of a measurement.
#pragma once

#include <ctime>
#include <fstream>
#include <string>

namespace skein::bench {

/// Processor time of all threads so far, s: what other programs disturb least.
inline double core_seconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

inline std::string processor() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return "unknown";
}

} // namespace skein::bench
