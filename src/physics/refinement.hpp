// Other numbers of elements for the same problem.
#pragma once

#include "skein/core/error.hpp"

#include <string>

namespace skein {

/// times/over elements for each one: 2/1 or 4/1, 1/2 for fewer.
struct Refinement {
    long times = 1, over = 1;
    /// Refined count of elements or nodes; -1: it is no whole number.
    long of(long count) const { return count * times % over == 0 ? count * times / over : -1; }
};

/// Throws InputError, with the source of a table.
[[noreturn]] inline void refuse_refinement(const std::string& source, const std::string& reason) {
    throw InputError(source + (source.empty() ? "" : ": ") + reason);
}

} // namespace skein
