// Selection of the checkpoints that stay as others are written.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

struct Keeping {
    std::int64_t newest = 2; ///< number of the newest ones, which stay
    bool milestones = true;  ///< older ones stay at doubling ages
};

/// Steps to keep of rising distinct `steps`. Ages count steps before the newest. After the newest ones, the next is the
/// oldest one of at most twice the age, or else the next older one. The first of all stays. So for every age of a
/// checkpoint one of at most twice that age is kept. Of M checkpoints at even intervals, at most newest + 2 log2(M) + 1
/// are kept. Repeated thinning keeps both properties.
std::vector<std::int64_t> kept_steps(std::span<const std::int64_t> steps, const Keeping& keeping);

} // namespace skein
