#include "io/keeping.hpp"

#include <algorithm>

namespace skein {

std::vector<std::int64_t> kept_steps(std::span<const std::int64_t> steps, const Keeping& keeping) {
    if (steps.empty()) return {};
    const std::size_t count = steps.size(),
                      newest = std::min(count, static_cast<std::size_t>(std::max<std::int64_t>(keeping.newest, 1)));
    std::vector<std::int64_t> kept(steps.rbegin(),
                                   steps.rbegin() + static_cast<std::ptrdiff_t>(newest)); // newest first
    std::size_t next = count - newest; // of the older ones: those before it are not yet decided
    while (keeping.milestones && next > 0) {
        const std::int64_t age = steps.back() - kept.back(), oldest = steps.back() - 2 * age;
        std::size_t chosen = next - 1;
        while (chosen > 0 && steps[chosen - 1] >= oldest) --chosen;
        kept.push_back(steps[chosen]);
        next = chosen;
    }
    std::reverse(kept.begin(), kept.end());
    return kept;
}

} // namespace skein
