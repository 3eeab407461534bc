// A space-filling curve: points near each other on the curve are near each other in space.
#pragma once

#include <cstdint>

namespace skein {

/// Hilbert index of a point in the unit cube, 21 bits per axis.
std::uint64_t hilbert_key(const double (&unit)[3]);

} // namespace skein
