#include "studies/gradient_study.hpp"

#include "core/nearest.hpp"
#include "core/timer.hpp"
#include "skein/core/error.hpp"
#include "studies/number_effects.hpp"
#include "studies/observable_slopes.hpp"
#include "studies/scene_number.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {

namespace {

constexpr double change_of_number = 1e-6; ///< of a number, by which it is changed to either side

/// Columns of these observables, or of all where none is named.
std::vector<std::size_t> columns_of(const std::vector<std::string>& of, const std::vector<std::string>& names) {
    std::vector<std::size_t> columns(names.size());
    std::iota(columns.begin(), columns.end(), std::size_t{0});
    if (of.empty()) return columns;
    std::vector<std::string_view> plain;
    for (const std::string& name : names) plain.push_back(std::string_view(name).substr(0, name.find('[')));
    columns.clear();
    for (const std::string& one : of) {
        auto found = std::find(names.begin(), names.end(), one) - names.begin();
        if (found == std::ssize(names)) found = std::find(plain.begin(), plain.end(), one) - plain.begin();
        if (found == std::ssize(names))
            throw InputError(
                fmt::format("'{}' is no observable of the scene{}", one, suggestion(one, plain, "there are")));
        columns.push_back(static_cast<std::size_t>(found));
    }
    return columns;
}

std::vector<ChangedNumber> numbers_of(const SceneSpec& scene, const std::vector<std::string>& keys,
                                      std::vector<NumberSlopes>& out) {
    std::vector<ChangedNumber> numbers;
    const std::vector<SceneNumber> found = numbers_at(scene, keys);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        refuse_whole(found[i], keys[i]);
        out.push_back({keys[i], found[i].unit, found[i].value, {}});
        numbers.push_back(
            {keys[i], found[i].value, change_of_number * (found[i].value != 0 ? std::abs(found[i].value) : 1)});
    }
    return numbers;
}

} // namespace

StateSlopes slopes_in(const Communicator& comm, const Threads& threads, const Machine& machine, ObservedCase& observed,
                      const StaticState& state, const GradientOptions& options) {
    const StaticCase& one = observed.at();
    StateSlopes found;
    GradientReport& report = found.report;
    const std::vector<ChangedNumber> numbers = numbers_of(one.scene, options.keys, report.numbers);
    RestQuantity quantity{nullptr, columns_of(options.of, observed.names())};
    for (const std::size_t column : quantity.observables) report.observables.push_back(observed.names()[column]);
    observed.take_friction(one.system->friction_memory(state));
    const Unknown value = quantity.at(observed, state);
    report.value = {value.begin(), value.end()};

    StaticSystem::Balance balance = one.system->balance(state, true);
    const Stiffness coupled = *balance.stiffness;
    const StaticSolution solution(*one.system, state, balance);
    found.regular = solution.regular();
    const std::vector<NumberEffect> effects =
        NumberEffects(comm, threads, machine, options.time, one, state, coupled).find(numbers, quantity, observed);
    for (const NumberEffect& effect : effects) found.loads.push_back(effect.loads);
    // The adjoint solutions; without them the whole quantity is followed along the change of each number.
    std::vector<Unknown> adjoint;
    report.rubs = one.system->has_history();
    if (!options.of.empty() && solution.symmetric() && !report.rubs)
        for (const std::string& name : report.observables) {
            const std::optional<Unknown> slope = slope_by_unknowns(one, state, name, options.time);
            if (!slope) break;
            adjoint.push_back(solution.adjoint(*slope));
        }
    const bool by_adjoint = adjoint.size() == report.observables.size();
    if (by_adjoint) report.adjoint = adjoint.size();
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        Unknown slope = effects[i].quantity;
        if (!by_adjoint) {
            const Unknown change = solution.solve(effects[i].loads);
            slope += slope_along(change, quantity, observed, state);
            report.numbers[i].slips = report.rubs && slips_along(change, solution, *one.system, state);
        }
        for (std::size_t j = 0; by_adjoint && j < adjoint.size(); ++j)
            slope[static_cast<Eigen::Index>(j)] += adjoint[j].dot(effects[i].loads);
        for (std::size_t j = 0; j < report.observables.size(); ++j)
            if (is_count(report.observables[j])) slope[static_cast<Eigen::Index>(j)] = 0;
        report.numbers[i].slope = {slope.begin(), slope.end()};
        report.numbers[i].jumps = effects[i].jumps;
    }
    return found;
}

GradientReport names_of(ObservedCase& observed, const Machine& machine, const GradientOptions& options) {
    GradientReport report;
    const std::vector<ChangedNumber> numbers = numbers_of(observed.at().scene, options.keys, report.numbers);
    require_changes(observed.at(), numbers, machine, options.time);
    for (const std::size_t column : columns_of(options.of, observed.names()))
        report.observables.push_back(observed.names()[column]);
    return report;
}

GradientReport gradients(const Communicator& comm, const Threads& threads, const Machine& machine,
                         const SceneText& text, const GradientOptions& options) {
    const double began = wall_seconds();
    const std::unique_ptr<StaticCase> one = static_case(text, machine, options.time);
    ObservedCase observed(comm, threads, *one, options.time);
    names_of(observed, machine, options); // refuses wrong ones before anything is solved
    StateSlopes found =
        slopes_in(comm, threads, machine, observed, equilibrium_of(*one, options.time, options.begun), options);
    if (!found.regular) refuse_singular();
    for (const NumberSlopes& number : found.report.numbers)
        if (number.jumps) refuse_jump(number.key, number.value);
    for (const NumberSlopes& number : found.report.numbers)
        if (number.slips) refuse_slip(number.key);
    found.report.seconds = wall_seconds() - began;
    return std::move(found.report);
}

std::string to_text(const GradientReport& report) {
    std::string text = fmt::format("Slopes at the equilibrium, per unit of each number; {:.3g} s\n", report.seconds);
    if (report.rubs) text += "Contacts stick: their springs of friction hold where they are\n";
    for (const NumberSlopes& number : report.numbers) {
        text += fmt::format("  by {} = {:g} {}\n", number.key, number.value, number.unit);
        for (std::size_t i = 0; i < number.slope.size(); ++i)
            if (number.slope[i] != 0 && std::isfinite(number.slope[i]))
                text += fmt::format("    {:<32} {:>16.9g}\n", report.observables[i], number.slope[i]);
    }
    return text;
}

} // namespace skein
