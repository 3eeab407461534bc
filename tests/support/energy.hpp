// Energy of one rod, and how it goes.
#pragma once

#include "diagnostics/observables.hpp"
#include "support/relaxation.hpp"

#include <limits>

namespace skein::test {

/// Kinetic and elastic, J.
inline double energy(const RodGroup& group, const std::vector<Slot<1>>& state) {
    const RodEnergy u = rod_energy(group, state);
    return u.translation + u.rotation + u.elastic();
}

/// Largest |E - E0|/E0 of the first rod over `samples` looks on the way to step `steps`; infinity where the rod is
/// lost.
inline double energy_drift(Stage& stage, std::int64_t steps, int samples, Cost& cost) {
    const RodGroup& group = stage.groups[0];
    const double start = energy(group, stage.state(0));
    double drift = 0;
    for (int s = 1; s <= samples; ++s) {
        advance(stage, steps * s / samples, cost);
        const double change = std::abs(energy(group, stage.state(0)) - start) / start;
        if (!std::isfinite(change)) return std::numeric_limits<double>::infinity();
        drift = std::max(drift, change);
    }
    return drift;
}

} // namespace skein::test
