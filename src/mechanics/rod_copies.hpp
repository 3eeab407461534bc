// Sums, strains and advanced copies of one rod's state, outside of kernels.
#pragma once

#include "tiles/rods.hpp"

namespace skein {

/// Figures of one rod at one time. `time`: time of turning walls, s.
RodFigures figures_of(const RodGroup& group, std::span<const Slot<1>> state, double time = 0, std::int64_t index = 0);

/// Profile of rod `index` at one time; `out` has a place per slot.
void rod_profile(const RodGroup& group, std::span<const Slot<1>> state, double time, std::span<NodeProfile> out,
                 std::int64_t index = 0);

/// Advances positions and directors by `h` at constant rates: a synchronised copy for outputs and diagnostics.
void synchronise(const RodGroup& group, std::span<Slot<1>> state, double h);
/// Advances positions alone, as most of the time goes into directors.
void synchronise_positions(const RodGroup& group, std::span<Slot<1>> state, double h);

} // namespace skein
