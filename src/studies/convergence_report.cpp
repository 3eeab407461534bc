#include "studies/convergence_report.hpp"

#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace skein {

namespace {

constexpr double least_share =
    1e-3;                          ///< of the largest range in its unit, for an observable to count towards a tolerance
constexpr double round_off = 1e-9; ///< of it: what changes less is not told at all
constexpr double least_change = 1e-12; ///< of its values: what moves less has not moved
constexpr double coarse_in_time = 0.1; ///< of its range, by which half a step changes what is not resolved

/// Columns of motion, which is over if ends at rest are compared.
bool of_motion(const std::string& name) {
    for (const char* stem : {"kinetic_", "momentum", "angular_momentum", "max_speed"})
        if (name.starts_with(stem)) return true;
    return false;
}

std::size_t common_samples(const Study& study, const std::array<RunSamples, 4>& samples) {
    std::size_t count = samples[0].times.size();
    for (const RunSamples& s : samples) count = std::min(count, s.times.size());
    for (std::size_t k = 0; k < samples.size(); ++k) {
        if (samples[k].quantities.size() != samples[0].quantities.size())
            throw IoError(study.runs[k].name + ": has other observables than " + study.runs[0].name);
        if (study.at_rest) continue;
        for (std::size_t i = 0; i < count; ++i)
            if (std::abs(samples[k].times[i] - samples[0].times[i]) > 1e-6 * study.duration)
                throw IoError(fmt::format("{}: sample {} is of t = {:g} s, but of {:g} s in {}", study.runs[k].name, i,
                                          samples[k].times[i], samples[0].times[i], study.runs[0].name));
    }
    return count;
}

/// Between two samples, s.
double interval_of(const RunSamples& samples) {
    return samples.times.size() > 1 ? samples.times[1] - samples.times[0] : HUGE_VAL;
}

/// One quantity of all runs.
ObservableError error_of(const Study& study, const std::array<RunSamples, 4>& samples, std::size_t number,
                         std::size_t count) {
    const Quantity& q = samples[study.given].quantities[number];
    const std::size_t width = q.components;
    std::array<std::span<const double>, 4> values;
    for (std::size_t k = 0; k < 4; ++k) {
        const auto& all = samples[k].quantities[number].values;
        values[k] = study.at_rest ? std::span(all).last(width) : std::span(all).first(count * width);
    }
    ObservableError o{.name = q.name, .unit = q.unit, .counts = !q.name.starts_with("max_")};
    o.range = range_of(samples[2].quantities[number].values, width);
    LevelValues levels{
        .given = study.given, .half_step = values[3], .time_order = study.time_order, .components = width};
    for (std::size_t k = 0; k < 3; ++k) {
        levels.space[k] = values[k];
        levels.dt[k] = study.halves_step() ? study.runs[k].dt : 1; // else all the same
    }
    for (const auto& run : study.runs) levels.steps = std::max(levels.steps, run.steps);
    o.convergence = converge(levels);
    const std::span<const double> start = std::span(q.values).first(width), end = values[study.given].last(width);
    const auto told = [&](std::span<const double> v) { return width == 1 ? v[0] : distance(v, start, width); };
    o.at_end = told(end);
    o.end.assign(end.begin(), end.end());
    const auto& limit = o.convergence.limit;
    if (!limit.empty()) {
        o.richardson_end.assign(limit.end() - static_cast<long>(width), limit.end());
        o.richardson = told(o.richardson_end);
    }
    for (std::size_t k = 0; k < 4; ++k)
        o.error[k] = distance(values[k], limit.empty() ? values[2] : std::span(limit), width);
    return o;
}

/// As the plan predicts, at the speed of all runs together: short ones take their time for other things than steps.
/// A relaxation counts as one step.
CostModel cost_of_runs(const Study& study, const StudyFigures& figures) {
    double measured = 0, predicted = 0;
    for (std::size_t k = 0; k < study.runs.size(); ++k) {
        measured += figures.core_seconds[k];
        predicted += study.runs[k].predicted;
    }
    CostModel cost;
    for (std::size_t k = 0; k < 3; ++k) {
        const StudyRun& run = study.runs[k];
        const double by_plan = measured / predicted * run.predicted / static_cast<double>(run.steps);
        cost.levels.push_back(
            {static_cast<double>(run.elements), run.dt_limit, study.halves_step() ? by_plan : figures.core_seconds[k]});
    }
    return cost;
}

/// A solution counts as one step. More elements never cost less: what they do within milliseconds is chance.
CostModel cost_of_solutions(const Study& study, const StudyFigures& figures) {
    CostModel cost;
    double most = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        most = std::max(most, figures.core_seconds[k]);
        cost.levels.push_back({static_cast<double>(study.runs[k].elements), 1, most});
    }
    return cost;
}

bool is_round_off(const Quantity& q) {
    double most = 0;
    for (const double value : q.values) most = std::max(most, std::abs(value));
    return range_of(q.values, q.components) < least_change * most;
}

} // namespace

StudyFigures figures_of(const Study& study, const std::array<RunSamples, 4>& samples,
                        const std::array<double, 4>& core_seconds) {
    StudyFigures figures{.core_seconds = core_seconds, .observables = {}, .notes = {}};
    const std::size_t count = common_samples(study, samples);
    for (std::size_t k = 0; k < study.made().size(); ++k) {
        const double end = samples[k].times.back();
        if (study.at_rest && !study.solved() && end > (1 - 1e-9) * study.duration)
            figures.notes.push_back(fmt::format("the run {} did not come to rest within the duration of {:g} s",
                                                study.runs[k].name, study.duration));
        if (!study.at_rest && end + interval_of(samples[0]) < (1 + 1e-9) * study.duration)
            figures.notes.push_back(
                fmt::format("the run {} ended early, at {:g} of {:g} s: all are compared up to {:g} s",
                            study.runs[k].name, end, study.duration, samples[0].times[count - 1]));
    }
    // Critical points count where a path has them, in place of its end.
    const bool has_own = std::any_of(samples[0].quantities.begin(), samples[0].quantities.end(),
                                     [](const Quantity& q) { return q.of_solution; });
    std::map<std::string, double> largest; // range, by unit
    for (std::size_t i = 0; i < samples[0].quantities.size(); ++i) {
        if (study.at_rest && of_motion(samples[0].quantities[i].name)) continue;
        if (is_round_off(samples[study.given].quantities[i])) continue;
        ObservableError o = error_of(study, samples, i, count);
        if (o.counts) largest[o.unit] = std::max(largest[o.unit], o.range);
        if (has_own) o.counts = samples[0].quantities[i].of_solution;
        figures.observables.push_back(std::move(o));
    }
    std::erase_if(figures.observables, [&](const ObservableError& o) {
        const double most = o.unit == "-" || o.unit == "rad" ? 1 : largest[o.unit];
        return !(o.range > round_off * most);
    });
    for (ObservableError& o : figures.observables) {
        if (!has_own && o.range < least_share * largest[o.unit]) o.counts = false;
        if (o.counts && o.convergence.error_bar.time > coarse_in_time * o.range)
            figures.notes.push_back(
                fmt::format("{}: half the step changes it by a good part of its range; the motion is chaotic or "
                            "the step too long to tell its error",
                            o.name));
    }
    return figures;
}

Advice advice_for(const Study& study, const StudyFigures& figures, double tolerance,
                  std::span<const std::string> names) {
    Advice advice{.tolerance = tolerance, .choice = {}, .by = {}, .untold = {}};
    std::vector<ErrorModel> models;
    for (const std::string& name : names)
        if (std::none_of(figures.observables.begin(), figures.observables.end(),
                         [&](const auto& o) { return o.name == name; }))
            throw InputError(
                fmt::format("--observable {}: there is none of this name that changes; the table lists them", name));
    for (const ObservableError& o : figures.observables) {
        const bool named = std::find(names.begin(), names.end(), o.name) != names.end();
        if (names.empty() ? !o.counts : !named) continue;
        if (o.convergence.smoothness == Smoothness::rough) {
            if (o.convergence.error_bar.total > tolerance * o.range) advice.untold.push_back(o.name);
            continue;
        }
        advice.by.push_back(o.name);
        models.push_back({.space = o.convergence.error_bar.space / o.range,
                          .space_order = o.convergence.order_used,
                          .time = o.convergence.error_bar.time / o.range,
                          .time_order = static_cast<double>(study.time_order)});
    }
    const StudyRun& given = study.runs[study.given];
    if (models.empty()) return advice;
    if (study.solved())
        advice.choice = cheapest(models, tolerance, given.elements, 1, cost_of_solutions(study, figures), 1);
    // Steps are as many as rods need to settle.
    else if (!study.halves_step())
        advice.choice = cheapest(models, tolerance, given.elements, given.dt, cost_of_runs(study, figures), given.dt);
    else
        advice.choice =
            cheapest(models, tolerance, given.elements, given.dt, cost_of_runs(study, figures), study.duration);
    return advice;
}

} // namespace skein
