// Energy balance from the sums of the audit's passes (mechanics/audit.hpp). theory.md section 16
#pragma once

#include "diagnostics/observables.hpp"

#include <string_view>

namespace skein {

inline constexpr std::string_view audit_names[] = {"work_loads[J]", "work_walls[J]", "dissipated[J]",
                                                   "energy_defect[J]"};
/// Beside these where rods feel a fluid.
inline constexpr std::string_view audit_fluid_name = "work_fluid[J]";
/// Beside these where implicit steps take energy by themselves.
inline constexpr std::string_view audit_steps_name = "numerical_loss[J]";

/// Kinetic and elastic energy at one time, and works since the rods were made, J.
struct EnergyAudit {
    double energy = 0, loads = 0, walls = 0, dissipated = 0;
    double contacts = 0;  ///< energy in springs of contacts, from their overlaps and not from their works
    double fluid = 0;     ///< work of a fluid that rods feel
    double numerical = 0; ///< taken by implicit steps
    /// Error of the balance, which is of second order in the step.
    double defect(double start_energy) const {
        return energy + contacts - loads - fluid - walls + dissipated + numerical - start_energy;
    }
};

/// Audit of rods.local()[i], without the energy of its contacts. `lag` drifts a copy to `time`.
EnergyAudit audit_rod(std::span<const RodGroup> groups, const Rods& rods, std::size_t i, double time, double lag);

/// Audit of the whole scene with its observed energy. Any distribution of rods gives the same bits. Collective.
EnergyAudit audit_scene(const Communicator& comm, const Rods& rods, double energy);

} // namespace skein
