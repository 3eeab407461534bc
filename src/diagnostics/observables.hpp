// Observables of the whole scene at one time: energies, momenta, extremes. Sums are exact before rounding
// (parallel/exact_sum.hpp), so any number of ranks and threads gives the same bits.
#pragma once

#include "diagnostics/extra_observables.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "tiles/rods.hpp"

#include <array>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Energies of one rod.                                                              theory.md (8)-(12)
struct RodEnergy {
    double translation = 0, rotation = 0;               ///< kinetic, J
    double stretch = 0, shear = 0, bend = 0, twist = 0; ///< elastic, J; bending of half cells at walls included
    double elastic() const { return stretch + shear + bend + twist; }
};
/// Energy of one rod. `time` [s] sets the places of turning walls.
RodEnergy rod_energy(const RodGroup& group, std::span<const Slot<1>> state, double time = 0, std::int64_t index = 0);

/// Names with units, in the order of observe().
std::vector<std::string> observable_names(const ObservableSets& sets = {});

/// Indices of some observables. The first `observed_energies` are energies, whose sum is the total.
inline constexpr std::size_t observed_translation = 0, observed_energies = 6, observed_centre = 9, observed_speed = 12,
                             observed_axial_strain = 13, observed_turn_per_cell = 14;
/// Kinetic and elastic energy of the scene, J, from values of observe().
double observed_energy(std::span<const double> observed);

/// Values at `time` [s], to which `lag` drifts copies, with optional `sets` at the end. Collective.
std::vector<double> observe(const Communicator& comm, const Threads& threads, std::span<const RodGroup> groups,
                            const Rods& rods, double time, double lag, const ObservableSets& sets = {});

} // namespace skein
