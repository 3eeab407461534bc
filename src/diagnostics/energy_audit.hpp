// The energy balance, from the sums that the audit's passes keep (mechanics/audit.hpp).       theory.md section 16
#pragma once

#include "diagnostics/observables.hpp"

#include <string_view>

namespace skein {

inline constexpr std::string_view audit_names[] = {"work_loads[J]", "work_walls[J]", "dissipated[J]",
                                                   "energy_defect[J]"};

/// Kinetic and elastic energy at one time, and what was done since the rods were made, J.
struct EnergyAudit {
    double energy = 0, loads = 0, walls = 0, dissipated = 0;
    double contacts = 0; ///< in the springs of contacts between bodies: by how much they overlap, not by what they did
    /// What the balance lacks; of the order of the step squared.
    double defect(double start_energy) const { return energy + contacts - loads - walls + dissipated - start_energy; }
};

/// Budget of rods.local()[i], without the energy of its contacts. `lag` moves a copy on to `time`.
EnergyAudit audit_rod(std::span<const RodGroup> groups, const Rods& rods, std::size_t i, double time, double lag);

/// Of the whole scene, whose energy has been observed. Collective; the same bits for any distribution of rods.
EnergyAudit audit_scene(const Communicator& comm, const Rods& rods, double energy);

} // namespace skein
