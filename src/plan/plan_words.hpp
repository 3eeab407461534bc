// Spelling of numbers in a printed plan.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>

namespace skein {

inline std::string bytes_text(double bytes) {
    constexpr const char* units[] = {"B", "kB", "MB", "GB", "TB", "PB"};
    std::size_t unit = 0;
    for (; bytes >= 1000 && unit + 1 < std::size(units); ++unit) bytes /= 1000;
    return fmt::format("{:.3g} {}", bytes, units[unit]);
}

inline std::string duration_text(double s) {
    if (s < 90) return fmt::format("{:.1f} s", s);
    if (s < 5400) return fmt::format("{:.0f} min", s / 60);
    return fmt::format("{:.1f} h", s / 3600);
}

template <class List> std::string joined(const List& list, const char* separator) {
    return fmt::format("{}", fmt::join(list, separator));
}

inline std::string counted(std::int64_t count, const char* what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

inline std::string every(std::int64_t steps, double dt) {
    return steps > 0 ? fmt::format("every {} steps ({:.4g} s)", steps, static_cast<double>(steps) * dt) : "none";
}

} // namespace skein
