#include "core/memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>

namespace skein {

namespace {

constexpr double unknown = std::numeric_limits<double>::infinity();

/// First number in a file; infinite where there is none ("max").
double number_in(const std::string& path) {
    std::ifstream file(path);
    double value;
    return file >> value ? value : unknown;
}

double left_by_machine() {
    std::ifstream file("/proc/meminfo");
    std::string name;
    for (double kilobytes; file >> name >> kilobytes; file.ignore(64, '\n'))
        if (name == "MemAvailable:") return 1024 * kilobytes;
    return unknown;
}

/// Bytes left by the control group of this process and by those around it, in either hierarchy.
double left_by_group() {
    double least = unknown;
    std::ifstream groups("/proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        const bool unified = line.starts_with("0::");
        if (!unified && line.find(":memory:") == std::string::npos) continue;
        const std::string root = unified ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
        std::string path = line.substr(line.rfind(':') + 1);
        for (;;) {
            const std::string at = root + path;
            const double limit = number_in(at + (unified ? "/memory.max" : "/memory.limit_in_bytes"));
            const double used = number_in(at + (unified ? "/memory.current" : "/memory.usage_in_bytes"));
            if (std::isfinite(limit) && std::isfinite(used)) least = std::min(least, limit - used);
            if (path.size() <= 1) break;
            path.erase(path.rfind('/'));
        }
    }
    return least;
}

double left_by_limit() {
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unknown;
    const double pages = number_in("/proc/self/statm"); // size of the address space
    const double used = std::isfinite(pages) ? pages * static_cast<double>(sysconf(_SC_PAGESIZE)) : 0;
    return static_cast<double>(limit.rlim_cur) - used;
}

} // namespace

double free_memory() { return std::max(0.0, std::min({left_by_machine(), left_by_group(), left_by_limit()})); }

} // namespace skein
