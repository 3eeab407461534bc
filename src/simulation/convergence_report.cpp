#include "simulation/convergence_report.hpp"

#include "io/files.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>

namespace skein {

namespace {

constexpr double least_share = 1e-3;   ///< of the largest range in its unit, for an observable to count towards a tolerance
constexpr double round_off = 1e-9;     ///< of it: what changes less is not told at all
constexpr double coarse_in_time = 0.1; ///< of its range, by which half a step changes what is not resolved

/// Of motion, which is over where ends at rest are compared.
bool of_motion(const std::string& name) {
    for (const char* stem : {"kinetic_", "momentum", "angular_momentum", "max_speed"})
        if (name.starts_with(stem)) return true;
    return false;
}

double norm(std::span<const double> v) {
    double sum = 0;
    for (const double x : v) sum += x * x;
    return std::sqrt(sum);
}

std::vector<double> minus(std::span<const double> a, std::span<const double> b) {
    std::vector<double> out(a.begin(), a.end());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] -= b[i];
    return out;
}

/// Of all samples the largest distance from the first.
double range_of(const Quantity& q) {
    const std::span<const double> values(q.values), start = values.first(q.components);
    double range = 0;
    for (std::size_t i = 0; i < values.size(); i += q.components)
        range = std::max(range, norm(minus(values.subspan(i, q.components), start)));
    return range;
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

/// One quantity of all runs.
ObservableError error_of(const Study& study, const std::array<RunSamples, 4>& samples, std::size_t number, std::size_t count) {
    const Quantity& q = samples[study.given].quantities[number];
    const std::size_t width = q.components;
    std::array<std::span<const double>, 4> values;
    for (std::size_t k = 0; k < 4; ++k) {
        const auto& all = samples[k].quantities[number].values;
        values[k] = study.at_rest ? std::span(all).last(width) : std::span(all).first(count * width);
    }
    ObservableError o{.name = q.name, .unit = q.unit, .counts = !q.name.starts_with("max_")};
    o.range = range_of(samples[2].quantities[number]);
    LevelValues levels{.given = study.given, .half_step = values[3], .time_order = study.time_order, .components = width};
    for (std::size_t k = 0; k < 3; ++k) levels.space[k] = values[k], levels.dt[k] = study.runs[k].dt;
    o.convergence = converge(levels);
    const std::span<const double> start = std::span(q.values).first(width), end = values[study.given].last(width);
    const auto told = [&](std::span<const double> v) { return width == 1 ? v[0] : norm(minus(v, start)); };
    o.at_end = told(end);
    o.end.assign(end.begin(), end.end());
    const auto& limit = o.convergence.limit;
    if (!limit.empty()) {
        o.richardson_end.assign(limit.end() - static_cast<long>(width), limit.end());
        o.richardson = told(o.richardson_end);
    }
    for (std::size_t k = 0; k < 4; ++k) o.error[k] = distance(values[k], limit.empty() ? values[2] : std::span(limit), width);
    return o;
}

std::string verdict(const ObservableError& o) {
    switch (o.convergence.smoothness) {
    case Smoothness::exact:
        return "no difference beyond round-off";
    case Smoothness::second:
        return "smooth";
    case Smoothness::other:
        return "smooth, but not of order 2: a wide bar";
    case Smoothness::rough:
        break;
    }
    return "not smooth: a bound from the spread of the runs";
}

std::string order_text(const ObservableError& o) {
    return std::isfinite(o.convergence.order) ? fmt::format("{:.2f}", o.convergence.order) : "-";
}

} // namespace

StudyFigures figures_of(const Study& study, const std::array<RunSamples, 4>& samples, const std::array<double, 4>& core_seconds) {
    StudyFigures figures{.core_seconds = core_seconds, .observables = {}, .notes = {}};
    const std::size_t count = common_samples(study, samples);
    if (study.at_rest)
        for (std::size_t k = 0; k < study.made().size(); ++k)
            if (samples[k].times.back() > (1 - 1e-9) * study.duration)
                figures.notes.push_back(fmt::format("the run {} did not come to rest within the duration of {:g} s",
                                                    study.runs[k].name, study.duration));
    std::map<std::string, double> largest; // range, by unit
    for (std::size_t i = 0; i < samples[0].quantities.size(); ++i) {
        if (study.at_rest && of_motion(samples[0].quantities[i].name)) continue;
        ObservableError o = error_of(study, samples, i, count);
        if (o.counts) largest[o.unit] = std::max(largest[o.unit], o.range);
        figures.observables.push_back(std::move(o));
    }
    std::erase_if(figures.observables, [&](const ObservableError& o) {
        const double most = o.unit == "-" || o.unit == "rad" ? 1 : largest[o.unit];
        return !(o.range > round_off * most);
    });
    for (ObservableError& o : figures.observables) {
        if (o.range < least_share * largest[o.unit]) o.counts = false;
        if (o.counts && o.convergence.bar.time > coarse_in_time * o.range)
            figures.notes.push_back(
                fmt::format("{}: half the step changes it by a good part of its range; the motion is chaotic or "
                            "the step too long to tell its error",
                            o.name));
    }
    return figures;
}

double core_seconds_of(const std::string& directory, double predicted) {
    using nlohmann::json;
    const json summary = json::parse(read_file(directory + "/summary.json"), nullptr, false);
    if (!summary.is_object() || !summary.contains("wall_s")) return predicted;
    const double steps = summary.value("steps", 0.0), made = steps - summary.value("first_step", 0.0);
    if (!(made > 0)) return predicted;
    double setup = 0;
    if (const auto phases = summary.find("phases"); phases != summary.end() && phases->contains("setup"))
        setup = (*phases)["setup"].value("max_s", 0.0);
    const int cores = summary.value("ranks", 1) * std::min(summary.value("threads", 1), summary.value("cores_per_rank", 1));
    return std::max(0.0, summary.value("wall_s", 0.0) - setup) * cores * steps / made;
}

Advice advice_for(const Study& study, const StudyFigures& figures, double tolerance, std::span<const std::string> names) {
    Advice advice{.tolerance = tolerance, .choice = {}, .by = {}, .untold = {}};
    std::vector<ErrorModel> models;
    for (const std::string& name : names)
        if (std::none_of(figures.observables.begin(), figures.observables.end(), [&](const auto& o) { return o.name == name; }))
            throw InputError(fmt::format("--observable {}: there is none of this name that changes; the table lists them", name));
    for (const ObservableError& o : figures.observables) {
        const bool named = std::find(names.begin(), names.end(), o.name) != names.end();
        if (names.empty() ? !o.counts : !named) continue;
        if (o.convergence.smoothness == Smoothness::rough) {
            if (o.convergence.bar.total > tolerance * o.range) advice.untold.push_back(o.name);
            continue;
        }
        advice.by.push_back(o.name);
        models.push_back({.space = o.convergence.bar.space / o.range,
                          .space_order = o.convergence.order_used,
                          .time = o.convergence.bar.time / o.range,
                          .time_order = static_cast<double>(study.time_order)});
    }
    // As the plan predicts, at the speed of all runs together: short ones take their time for other things than steps.
    double measured = 0, predicted = 0;
    for (std::size_t k = 0; k < study.runs.size(); ++k) measured += figures.core_seconds[k], predicted += study.runs[k].predicted;
    CostModel cost;
    for (std::size_t k = 0; k < 3; ++k) {
        const StudyRun& run = study.runs[k];
        cost.levels.push_back({static_cast<double>(run.elements), run.dt_limit,
                               measured / predicted * run.predicted / static_cast<double>(run.steps)});
    }
    const StudyRun& given = study.runs[study.given];
    double duration = study.duration;
    if (study.relaxes) { // steps are as many as rods need to settle
        for (std::size_t k = 0; k < 3; ++k) cost.levels[k].core_seconds_per_step = figures.core_seconds[k];
        duration = given.dt;
    }
    if (!models.empty()) advice.choice = cheapest(models, tolerance, given.elements, given.dt, cost, duration);
    return advice;
}

std::string runs_text(const Study& study) {
    std::string text =
        fmt::format("  {:<18}{:>10}{:>14}{:>12}{:>24}\n", "run", "elements", "dt, s", "steps", "predicted core-seconds");
    double sum = 0;
    for (std::size_t k = 0; k < study.made().size(); ++k) {
        const StudyRun& r = study.runs[k];
        text += fmt::format("  {:<18}{:>10}{:>14.6g}{:>12}{:>24.3g}{}\n", r.name, r.elements, r.dt, r.steps, r.predicted,
                            k == study.given ? "   as given" : "");
        sum += r.predicted;
    }
    text += fmt::format("  {:<54}{:>24.3g}\n", "all", sum);
    if (study.relaxes) text += "  note: runs end when rods have settled, so they take these times at most\n";
    for (const std::string& note : study.notes) text += "  note: " + note + "\n";
    return text;
}

std::string to_text(const Study& study, const StudyFigures& figures) {
    std::string text =
        fmt::format("\nErrors of the run as given, {} elements and dt = {:.6g} s; bars over the range of each observable, {}\n",
                    study.runs[study.given].elements, study.runs[study.given].dt,
                    study.at_rest ? "of its end at rest" : "the largest of all samples");
    text += fmt::format("  {:<32}{:>13}{:>13}{:>7}{:>10}{:>10}{:>10}{:>12}  {}\n", "observable", "at the end", "Richardson",
                        "order", "space", "time", "total", "at the end", "convergence");
    for (const ObservableError& o : figures.observables) {
        const auto share = [&](double bar) { return fmt::format("{:.2g}", bar / o.range); };
        text += fmt::format("  {:<32}{:>13.6g}{:>13}{:>7}{:>10}{:>10}{:>10}{:>12}  {}{}\n", fmt::format("{} [{}]", o.name, o.unit),
                            o.at_end, o.richardson ? fmt::format("{:.6g}", *o.richardson) : "-", order_text(o),
                            share(o.convergence.bar.space), share(o.convergence.bar.time), share(o.convergence.bar.total),
                            fmt::format("+-{:.2g}", o.convergence.bar_at_end.total), verdict(o),
                            o.counts ? "" : " (does not count towards a tolerance)");
    }
    for (const std::string& note : figures.notes) text += "  note: " + note + "\n";
    return text;
}

std::string to_text(const Study& study, const Advice& advice) {
    std::string text;
    const StudyRun& given = study.runs[study.given];
    if (advice.choice) {
        text = fmt::format("For {:g} of the range: {} elements{}, about {:.3g} core-seconds\n", advice.tolerance,
                           advice.choice->elements, study.relaxes ? "" : fmt::format(" and dt = {:.4g} s", advice.choice->dt),
                           advice.choice->core_seconds);
        if (advice.choice->elements > study.runs[2].elements || 2 * advice.choice->elements < given.elements)
            text += "  that is beyond the runs that were made: run converge again from there\n";
        std::size_t groups = 0;
        for (const RodSpec& rods : given.scene.rods) groups += rods.body ? 0 : 1;
        if (groups > 1) text += "  of the group with the most; the others in proportion\n";
    } else if (!advice.by.empty()) {
        text = fmt::format("For {:g} of the range: not with 64 times as many elements\n", advice.tolerance);
    }
    if (!advice.untold.empty())
        text += fmt::format("  no numbers can be told for what does not converge smoothly: {}\n", fmt::join(advice.untold, ", "));
    if (advice.by.empty() && advice.untold.empty()) text += "No observable changes: there is nothing to choose numbers by\n";
    return text;
}

std::string to_json(const Study& study, const StudyFigures& figures, const Advice* advice) {
    using json = nlohmann::ordered_json;
    const auto number = [](double x) { return std::isfinite(x) ? json(x) : json(nullptr); };
    static constexpr std::array<const char*, 4> smoothness = {"exact", "second order", "other order", "not smooth"};
    json runs = json::array(), observables = json::array();
    for (std::size_t k = 0; k < study.made().size(); ++k) {
        const StudyRun& r = study.runs[k];
        runs.push_back({{"directory", r.name},
                        {"elements", r.elements},
                        {"dt_s", r.dt},
                        {"steps", r.steps},
                        {"as_given", k == study.given},
                        {"core_seconds", figures.core_seconds[k]},
                        {"predicted_core_seconds", r.predicted}});
    }
    for (const ObservableError& o : figures.observables) {
        const auto bar = [](const Convergence::Bar& b) { return json{{"space", b.space}, {"time", b.time}, {"total", b.total}}; };
        const Convergence& c = o.convergence;
        observables.push_back({{"name", o.name},
                               {"unit", o.unit},
                               {"range", o.range},
                               {"counts", o.counts},
                               {"convergence", smoothness[static_cast<std::size_t>(c.smoothness)]},
                               {"order", number(c.order)},
                               {"at_end", o.end},
                               {"richardson_at_end", o.richardson ? json(o.richardson_end) : json(nullptr)},
                               {"bar", bar(c.bar)},
                               {"bar_at_end", bar(c.bar_at_end)},
                               {"spread_of_last_two", c.spread},
                               {"errors", std::vector(o.error.begin(), o.error.begin() + static_cast<long>(runs.size()))}});
    }
    json out = {{"format", study_format},   {"version", 1}, {"title", study.runs[study.given].scene.title},
                {"at_rest", study.at_rest}, {"runs", runs}, {"observables", observables},
                {"notes", figures.notes}};
    if (advice) {
        out["advice"] = {{"tolerance", advice->tolerance}, {"by", advice->by}, {"untold", advice->untold}};
        if (advice->choice)
            out["advice"].update({{"elements", advice->choice->elements},
                                  {"dt_s", advice->choice->dt},
                                  {"core_seconds", advice->choice->core_seconds}});
    }
    return out.dump(2) + "\n";
}

std::string to_csv(const Study& study, const StudyFigures& figures) {
    std::string text = "observable,unit,run,elements,dt[s],core_seconds[s],error,error_over_range\n";
    for (const ObservableError& o : figures.observables)
        for (std::size_t k = 0; k < study.made().size(); ++k) {
            const StudyRun& r = study.runs[k];
            text += fmt::format("{},{},{},{},{:.17g},{:.6g},{:.6g},{:.6g}\n", o.name, o.unit, r.name, r.elements, r.dt,
                                figures.core_seconds[k], o.error[k], o.error[k] / o.range);
        }
    return text;
}

} // namespace skein
