// Sums, strains and moved copies of one rod's state, outside of kernels.
#pragma once

#include "tiles/rods.hpp"

namespace skein {

/// Of one rod at one time. `time`: where walls that turn stand, s.
RodFigures figures_of(const RodGroup& group, std::span<const Slot<1>> state, double time = 0, std::int64_t index = 0);

/// Of rod `index` at one time; `out` has a place per slot.
void rod_profile(const RodGroup& group, std::span<const Slot<1>> state, double time, std::span<NodeProfile> out,
                 std::int64_t index = 0);

/// Positions and directors moved on by `h` at constant rates: a synchronised copy for outputs and diagnostics.
void synchronise(const RodGroup& group, std::span<Slot<1>> state, double h);
/// The same of positions alone: most of the time goes into directors.
void synchronise_positions(const RodGroup& group, std::span<Slot<1>> state, double h);

} // namespace skein
