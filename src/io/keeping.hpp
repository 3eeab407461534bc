// Which checkpoints stay as others are written.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

struct Keeping {
    std::int64_t newest = 2; ///< these stay
    bool milestones = true;  ///< and, of older ones, some at doubling ages
};

/// The steps to keep, of rising distinct `steps`. Ages are steps before the newest. Behind the newest ones kept, the
/// next is always the oldest one of at most twice the age, or else the next older one; the first of all stays. So for
/// any age there was a checkpoint of, one is kept that is at most twice as old, and of M checkpoints at even intervals
/// no more than newest + 2 log2(M) + 1 are kept. Thinning what was thinned before loses nothing of that.
std::vector<std::int64_t> kept_steps(std::span<const std::int64_t> steps, const Keeping& keeping);

} // namespace skein
