#include "coupling/overlap_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace skein {

void OverlapWatch::take(double now, std::int64_t step) {
    overlap = std::max(overlap, now);
    if (passed < 0 && now > allowed) passed = step;
}

LargestOverlap OverlapWatch::largest(const Communicator& comm) const {
    constexpr auto never = std::numeric_limits<std::int64_t>::max();
    const std::int64_t first = comm.min(passed < 0 ? never : passed);
    LargestOverlap one{of, comm.max(overlap), allowed, first == never ? -1 : first};
    const double ratio = one.overlap / one.allowed;
    const double in_springs = normal == ContactNormal::linear ? ratio * ratio : ratio * ratio * std::sqrt(ratio);
    one.times = std::max(in_springs, comm.max(times));
    one.stiffness = stiffness;
    return one;
}

std::string LargestOverlap::warning() const {
    if (passed < 0) return {};
    std::string text =
        fmt::format("{} overlap by {:.3g} of the diameter, since step {} by more than the {:g} that the time step "
                    "allows for",
                    of == "rods" ? "rods" : fmt::format("rods and wall '{}'", of), overlap, passed, allowed);
    if (stiffness > 0)
        text +=
            fmt::format("; stiffness = {:.2g} in place of {:.4g} would hold them there", times * stiffness, stiffness);
    else text += fmt::format("; {:.2g} times the stiffness would hold them there", times);
    return text;
}

} // namespace skein
