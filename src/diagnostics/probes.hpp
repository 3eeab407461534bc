// Probes: quantities at single places of rods and bodies, as columns of the time series.
#pragma once

#include "parallel/communicator.hpp"
#include "skein/core/fields.hpp"
#include "skein/rod/rod_group.hpp"
#include "tiles/rods.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

enum class ProbeQuantity { position, velocity, direction, spin, strain, curvature, fluid_force, fluid_couple };
inline constexpr std::string_view probe_quantity_names[] = {"position", "velocity",  "direction",   "spin",
                                                            "strain",   "curvature", "fluid_force", "fluid_couple"};

/// [[probe]]
struct ProbeSpec {
    std::string name; ///< of its columns
    std::string of;   ///< group of rods or bodies
    long number = 0;  ///< of the rod or body in its group
    double at = 1;    ///< place over the length of a rod at rest
    ProbeQuantity quantity = ProbeQuantity::position;
    std::string source; ///< file:line of the table, for messages

    static constexpr bool output_only = true;

    void fields(FieldVisitor& f);
    /// True for quantities of the strained axis, which bodies do not have.
    bool strained() const { return quantity == ProbeQuantity::strain || quantity == ProbeQuantity::curvature; }
    /// True for quantities of a whole rod or body that the fluid has: FluidPlan::load_columns.
    bool of_fluid() const { return quantity == ProbeQuantity::fluid_force || quantity == ProbeQuantity::fluid_couple; }
};

/// Place of a probe on a rod: an element, and the share of it that lies before.
struct ProbePlace {
    std::size_t element;
    double share;
};
/// `at`: over the length of the rod at rest.
ProbePlace probe_place(const RodGroup& rod, double at);

/// Columns with units, in the order of probe_values(), without quantities of the fluid.
std::vector<std::string> probe_names(std::span<const ProbeSpec> probes);

/// Values of the state, to which `lag` [s] drifts copies. Collective.
std::vector<double> probe_values(const Communicator& comm, std::span<const RodGroup> groups, const Rods& rods,
                                 double lag, std::span<const ProbeSpec> probes);

} // namespace skein
