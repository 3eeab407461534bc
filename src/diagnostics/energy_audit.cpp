#include "diagnostics/energy_audit.hpp"

#include "mechanics/rod_copies.hpp"
#include "parallel/exact_sum.hpp"
#include "skein/core/index.hpp"

namespace skein {

EnergyAudit audit_rod(std::span<const RodGroup> groups, const Rods& rods, std::size_t i, double time, double lag) {
    const RodGroup& group = nth(groups, rods.local()[i].group);
    std::vector<Slot<1>> copy(to_index(group.slots()));
    rods.export_rod(i, copy);
    synchronise(group, copy, lag);
    const RodEnergy u = rod_energy(group, copy, time, rods.local()[i].index);
    const RodBudget w = rods.budget(i);
    return {u.translation + u.rotation + u.elastic(), w.loads, w.walls, w.dissipated, 0, w.fluid, w.numerical};
}

EnergyAudit audit_scene(const Communicator& comm, const Rods& rods, double energy) {
    std::vector<std::vector<double>> columns(5, std::vector<double>(rods.local().size()));
    for (std::size_t i = 0; i < rods.local().size(); ++i) {
        const RodBudget w = rods.budget(i);
        columns[0][i] = w.loads;
        columns[1][i] = w.walls;
        columns[2][i] = w.dissipated;
        columns[3][i] = w.fluid;
        columns[4][i] = w.numerical;
    }
    const std::vector<double> sum = exact_sums(comm, columns);
    return {energy, sum[0], sum[1], sum[2], 0, sum[3], sum[4]};
}

} // namespace skein
