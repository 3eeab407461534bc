#include "io/keeping.hpp"

#include "skein/core/index.hpp"

#include <algorithm>

namespace skein {

std::vector<std::int64_t> kept_steps(std::span<const std::int64_t> steps, const Keeping& keeping) {
    if (steps.empty()) return {};
    const auto count = std::ssize(steps), newest = std::clamp<std::ptrdiff_t>(keeping.newest, 1, count);
    std::vector<std::int64_t> kept(steps.rbegin(), steps.rbegin() + newest); // newest first
    std::size_t next = to_index(count - newest);                             // older ones before it are undecided
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
