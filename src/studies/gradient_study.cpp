#include "studies/gradient_study.hpp"

#include "core/timer.hpp"
#include "studies/scene_number.hpp"
#include "studies/static_slopes.hpp"

#include <fmt/format.h>

#include <cmath>

namespace skein {

namespace {

constexpr double share = 1e-4; ///< of a number, by which it is changed to either side

} // namespace

GradientReport gradients(const Communicator& comm, const Threads& threads, const Machine& machine,
                         const SceneText& text, const std::vector<std::string>& keys, double time) {
    const double began = wall_seconds();
    const std::unique_ptr<StaticCase> one = static_case(text, machine, time);
    const StaticState state = equilibrium_of(*one, time);
    GradientReport report;
    ObservedState here = observe(comm, threads, *one, state);
    report.observables = std::move(here.names);
    report.value = std::move(here.values);
    StaticSystem::Balance balance = one->system->balance(state, true);
    const StaticSolution solution(*one->system, state, balance);
    for (const std::string& key : keys) {
        const SceneNumber number = number_at(one->scene, key);
        refuse_whole(number, key);
        const auto [low, high] =
            changed_cases(share * (number.value != 0 ? std::abs(number.value) : 1), [&](double by) {
                SceneText other = text;
                other.overrides.push_back(fmt::format("{}={:.17g}", key, number.value + by));
                return static_case(other, machine, time);
            });
        const Unknown slope =
            slopes_at_rest(solution, state, low, high, [&](const StaticCase& at, const StaticState& own) {
                const std::vector<double> values = observe(comm, threads, at, own).values;
                return Unknown(Eigen::Map<const Unknown>(values.data(), static_cast<Eigen::Index>(values.size())));
            });
        report.numbers.push_back({key, number.unit, number.value, {slope.begin(), slope.end()}});
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
