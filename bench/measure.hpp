// Time and place of a measurement.
#pragma once

#include "support/core_seconds.hpp"

#include <fstream>
#include <string>

namespace skein::bench {

using test::core_seconds;

inline std::string processor() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return "unknown";
}

} // namespace skein::bench
