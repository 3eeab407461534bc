#include "diagnostics/energy_audit.hpp"

#include "parallel/exact_sum.hpp"

namespace skein {

EnergyAudit audit_rod(std::span<const RodGroup> groups, const Rods& rods, std::size_t i, double time, double lag) {
    const RodGroup& group = groups[static_cast<std::size_t>(rods.local()[i].group)];
    std::vector<Slot<1>> copy(static_cast<std::size_t>(group.slots()));
    rods.export_rod(i, copy);
    synchronise(group, copy, lag);
    const RodEnergy u = rod_energy(group, copy, time);
    const RodWorks w = rods.works(i);
    return {u.translation + u.rotation + u.elastic(), w.loads, w.walls, w.dissipated};
}

EnergyAudit audit_scene(const Communicator& comm, const Threads& threads, std::span<const RodGroup> groups, const Rods& rods, double time, double lag) {
    std::vector<std::vector<double>> columns(4, std::vector<double>(rods.local().size()));
    threads.for_each(rods.local().size(), [&](std::size_t i, int) {
        const EnergyAudit a = audit_rod(groups, rods, i, time, lag);
        columns[0][i] = a.energy;
        columns[1][i] = a.loads;
        columns[2][i] = a.walls;
        columns[3][i] = a.dissipated;
    });
    const std::vector<double> sum = exact_sums(comm, columns);
    return {sum[0], sum[1], sum[2], sum[3]};
}

} // namespace skein
