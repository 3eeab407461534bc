#include "core/level.hpp"

#include "skein/core/error.hpp"

#include <algorithm>
#include <cstdlib>
#include <string>

namespace skein {

namespace {

/// Widest registers that processor and operating system have for packs, in doubles.
int processor_lanes() {
#if defined(__x86_64__)
    __builtin_cpu_init();
    const auto all = [](auto... has) { return (has && ...); };
    const bool v3 = all(__builtin_cpu_supports("avx2"), __builtin_cpu_supports("fma"), __builtin_cpu_supports("bmi"),
                        __builtin_cpu_supports("bmi2"));
    const bool v4 = v3 && all(__builtin_cpu_supports("avx512f"), __builtin_cpu_supports("avx512bw"),
                              __builtin_cpu_supports("avx512cd"), __builtin_cpu_supports("avx512dq"),
                              __builtin_cpu_supports("avx512vl"));
    return v4 ? 8 : v3 ? 4 : 2;
#else
    return 2;
#endif
}

void require_level(int lanes, const char* who) {
    for (const Level& level : levels)
        if (level.lanes == lanes) return;
    throw InputError(std::string(who) + " must be 1, 2, 4 or 8, not " + std::to_string(lanes));
}

} // namespace

int widest_lanes() {
    int lanes = processor_lanes();
    if (const char* text = std::getenv("SKEIN_LANES")) {
        const int most = std::atoi(text);
        require_level(most, "environment variable SKEIN_LANES");
        lanes = std::min(lanes, most);
    }
    return served_lanes(lanes);
}

int served_lanes(int asked) {
    require_level(asked, "lanes");
    const int most = processor_lanes();
    return most == 2 ? 2 : std::min(asked, most);
}

std::string_view level_name(int lanes) {
    for (const Level& level : levels)
        if (level.lanes == lanes) return level.name;
    return {};
}

} // namespace skein
