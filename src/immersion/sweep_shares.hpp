// Shares by which the changes of sweeps are scaled. All sweeps together then change no slip by more than three times
// the first sweep's change. theory.md (90b)
#pragma once

#include <vector>

namespace skein {

/// Most sweeps without shares under two-way coupling. With more, residual impulses reach rods too late for stability.
inline constexpr int most_plain_sweeps = 3;

/// Factor of the change of each of so many sweeps; 1 for up to most_plain_sweeps.
std::vector<double> sweep_shares(int sweeps);

} // namespace skein
