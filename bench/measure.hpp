// Time and place of a measurement.
#pragma once

#include "support/core_seconds.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

namespace skein::bench {

using test::core_seconds;

inline std::string processor() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return "unknown";
}

inline double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace skein::bench
