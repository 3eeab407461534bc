#include "studies/gradient_study.hpp"

#include "core/timer.hpp"
#include "scene/scene_file.hpp"
#include "simulation/simulation.hpp"
#include "skein/core/error.hpp"
#include "studies/scene_number.hpp"

#include <fmt/format.h>

#include <cmath>

namespace skein {

namespace {

constexpr double share = 1e-4; ///< of a number, by which it is changed to either side

/// Observables of a case in a state.
class Observed {
public:
    Observed(const Communicator& comm, const Threads& threads, const StaticCase& one, const StaticState& state)
        : simulation_(comm, threads, one.scene, one.groups, one.plan, {.quiet = true}) {
        Rods& rods = simulation_.world().rods();
        for (std::size_t i = 0; i < rods.local().size(); ++i) {
            const auto rod = static_cast<std::size_t>(rods.local()[i].gid);
            const auto begin = state.slot.begin();
            const std::vector<Slot<1>> own(begin + static_cast<std::ptrdiff_t>(one.system->first_slot(rod)),
                                           begin + static_cast<std::ptrdiff_t>(one.system->first_slot(rod + 1)));
            rods.import_rod(i, own);
        }
    }
    std::vector<std::string> names() const { return simulation_.observation().names(); }
    std::vector<double> values() const { return simulation_.observation().values(); }

private:
    Simulation simulation_;
};

StaticState equilibrium_of(StaticCase& one, double time) {
    StaticState state = start_of(*one.system, one.groups, one.rods);
    NewtonSolver newton(*one.system, {});
    const Equilibrium found = newton.find(state, time);
    if (!found.found) throw NumericalError(fmt::format("no equilibrium was found: {}", found.reason));
    one.system->refresh(state);
    return state;
}

} // namespace

GradientReport gradients(const Communicator& comm, const Threads& threads, const Machine& machine,
                         const SceneText& text, const std::vector<std::string>& keys, double time) {
    const double began = wall_seconds();
    const std::unique_ptr<StaticCase> one = static_case(text, machine, time);
    const StaticState state = equilibrium_of(*one, time);
    GradientReport report;
    {
        const Observed here(comm, threads, *one, state);
        report.observables = here.names();
        report.value = here.values();
    }
    StaticSystem::Balance balance = one->system->balance(state, true);
    const StaticSolution solution(*one->system, state, balance);
    for (const std::string& key : keys) {
        const SceneNumber number = number_at(one->scene, key);
        refuse_whole(number, key);
        const double h = share * (number.value != 0 ? std::abs(number.value) : 1);
        const auto beside = [&](double side) {
            SceneText other = text;
            other.overrides.push_back(fmt::format("{}={:.17g}", key, number.value + side * h));
            return static_case(other, machine, time);
        };
        const std::unique_ptr<StaticCase> low = beside(-1), high = beside(1);
        const auto residual = [&](StaticCase& at) {
            StaticState own = state;
            at.system->lead_ends(own);
            return at.system->balance(own, false).residual;
        };
        const Unknown along = solution.solve((residual(*high) - residual(*low)) / (2 * h));
        const auto moved = [&](StaticCase& at, double side) {
            StaticState own = state;
            at.system->lead_ends(own);
            at.system->correct(own, side * h * along, 1);
            return Observed(comm, threads, at, own).values();
        };
        const std::vector<double> above = moved(*high, 1), below = moved(*low, -1);
        NumberSlopes& slopes = report.numbers.emplace_back(NumberSlopes{key, number.unit, number.value, {}});
        for (std::size_t i = 0; i < above.size(); ++i) slopes.slope.push_back((above[i] - below[i]) / (2 * h));
    }
    report.seconds = wall_seconds() - began;
    return report;
}

std::string to_text(const GradientReport& report) {
    std::string text = fmt::format("Slopes at the equilibrium, per unit of each number; {:.3g} s\n", report.seconds);
    for (const NumberSlopes& number : report.numbers) {
        text += fmt::format("  by {} = {:g} {}\n", number.key, number.value, number.unit);
        for (std::size_t i = 0; i < number.slope.size(); ++i)
            if (number.slope[i] != 0)
                text += fmt::format("    {:<32} {:>16.9g}\n", report.observables[i], number.slope[i]);
    }
    return text;
}

} // namespace skein
