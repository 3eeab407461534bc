// Shares of the changes of sweeps, so that all together change no slip by more than three times what the first sweep
// does. theory.md (90b)
#pragma once

#include <vector>

namespace skein {

/// Sweeps that go as they are where rods feel the fluid: with more, what is owed to rods comes back too late for them
/// to be stable.
inline constexpr int most_plain_sweeps = 3;

/// By what the change of each of so many sweeps is multiplied; up to most_plain_sweeps 1.
std::vector<double> sweep_shares(int sweeps);

} // namespace skein
