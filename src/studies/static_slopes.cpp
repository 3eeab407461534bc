#include "studies/static_slopes.hpp"

#include "equilibrium/newton.hpp"
#include "simulation/simulation.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

namespace skein {

StaticState equilibrium_of(StaticCase& one, double time) {
    StaticState state = start_of(*one.system, one.groups, one.rods);
    NewtonSolver newton(*one.system, {});
    const Equilibrium found = newton.find(state, time);
    if (!found.found) throw NumericalError(fmt::format("no equilibrium was found: {}", found.reason));
    one.system->refresh(state);
    return state;
}

ObservedState observe(const Communicator& comm, const Threads& threads, const StaticCase& one,
                      const StaticState& state) {
    Simulation simulation(comm, threads, one.scene, one.groups, one.plan, {.quiet = true});
    Rods& rods = simulation.world().rods();
    for (std::size_t i = 0; i < rods.local().size(); ++i) {
        const auto rod = static_cast<std::size_t>(rods.local()[i].gid);
        const auto begin = state.slot.begin();
        const std::vector<Slot<1>> own(begin + static_cast<std::ptrdiff_t>(one.system->first_slot(rod)),
                                       begin + static_cast<std::ptrdiff_t>(one.system->first_slot(rod + 1)));
        rods.import_rod(i, own);
    }
    return {simulation.observation().names(), simulation.observation().values()};
}

std::pair<ChangedCase, ChangedCase> changed_cases(double by,
                                                  const std::function<std::unique_ptr<StaticCase>(double)>& make) {
    ChangedCase low, high;
    try {
        low = {make(-by), -by};
    } catch (const InputError&) {
        low = {make(0), 0};
        high = {make(by), by};
        return {std::move(low), std::move(high)};
    }
    try {
        high = {make(by), by};
    } catch (const InputError&) {
        high = {make(0), 0};
    }
    return {std::move(low), std::move(high)};
}

Unknown slopes_at_rest(const StaticSolution& solution, const StaticState& state, const ChangedCase& low,
                       const ChangedCase& high,
                       const std::function<Unknown(const StaticCase&, const StaticState&)>& quantity) {
    const double width = high.by - low.by;
    const auto residual = [&](const ChangedCase& one) {
        StaticState own = state;
        one.at->system->lead_ends(own);
        return one.at->system->balance(own, false).residual;
    };
    const Unknown along = solution.solve((residual(high) - residual(low)) / width);
    const auto moved = [&](const ChangedCase& one) {
        StaticState own = state;
        one.at->system->lead_ends(own);
        one.at->system->correct(own, one.by * along, 1);
        return quantity(*one.at, own);
    };
    return (moved(high) - moved(low)) / width;
}

} // namespace skein
