// Events that come every so many steps.
#pragma once

#include <cstdint>
#include <limits>

namespace skein {

struct Every {
    static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

    std::int64_t steps = 0; ///< 0: never

    constexpr bool due(std::int64_t step) const { return steps > 0 && step % steps == 0; }
    /// First step after `done` at which it is due.
    constexpr std::int64_t next(std::int64_t done) const { return steps > 0 ? (done / steps + 1) * steps : never; }
    /// First step from `step` on at which it is due; it must not be never.
    constexpr std::int64_t from(std::int64_t step) const { return (step + steps - 1) / steps * steps; }
    /// Last step up to `step` at which it was due; it must not be never.
    constexpr std::int64_t last(std::int64_t step) const { return step / steps * steps; }
};

} // namespace skein
