#include "simulation/settling.hpp"

#include <cstdio>

#include <fmt/format.h>

namespace skein {

void Settling::tell(std::int64_t steps, std::int64_t allowed, bool quiet) const {
    const std::string wanted = fmt::format(
        "the largest correction that a rod wants is {:.3g}, time.relax_tolerance {:g}", correction_, tolerance_);
    if (settled() && !quiet) std::printf("Settled in %lld steps: %s\n", static_cast<long long>(steps), wanted.c_str());
    if (!settled() && steps >= allowed)
        std::fprintf(stderr, "not settled in the %lld steps of time.duration: %s\n", static_cast<long long>(allowed),
                     wanted.c_str());
}

} // namespace skein
