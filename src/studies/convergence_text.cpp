#include "studies/convergence_text.hpp"

#include "skein/core/index.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <limits>

namespace skein {

namespace {

std::string verdict(const ObservableError& o) {
    switch (o.convergence.smoothness) {
    case Smoothness::exact:
        return "no difference beyond round-off";
    case Smoothness::second:
        return "smooth";
    case Smoothness::other:
        return "smooth, but not of order 2: a wide error bar";
    case Smoothness::rough:
        break;
    }
    return "not smooth: a bound from the spread of the runs";
}

std::string order_text(const ObservableError& o) {
    return std::isfinite(o.convergence.order) ? fmt::format("{:.2f}", o.convergence.order) : "-";
}

std::string notes_text(const std::vector<std::string>& notes) {
    std::string text;
    for (const std::string& note : notes) text += "  note: " + note + "\n";
    return text;
}

std::string solutions_text(const Study& study) {
    std::string text = fmt::format("  {:<18}{:>10}\n", "solution", "elements");
    for (std::size_t k = 0; k < study.made().size(); ++k)
        text += fmt::format("  {:<18}{:>10}{}\n", study.runs[k].name, study.runs[k].elements,
                            k == study.given ? "   as given" : "");
    return text + notes_text(study.notes);
}

} // namespace

std::string runs_text(const Study& study) {
    if (study.solved()) return solutions_text(study);
    std::string text = fmt::format("  {:<18}{:>10}{:>14}{:>12}{:>24}\n", "run", "elements", "dt, s", "steps",
                                   "predicted core-seconds");
    double sum = 0;
    for (std::size_t k = 0; k < study.made().size(); ++k) {
        const StudyRun& r = study.runs[k];
        text += fmt::format("  {:<18}{:>10}{:>14.6g}{:>12}{:>24.3g}{}\n", r.name, r.elements, r.dt, r.steps,
                            r.predicted, k == study.given ? "   as given" : "");
        sum += r.predicted;
    }
    text += fmt::format("  {:<54}{:>24.3g}\n", "all", sum);
    if (!study.halves_step()) text += "  note: runs end when rods have settled, so they take these times at most\n";
    return text + notes_text(study.notes);
}

std::string to_text(const Study& study, const StudyFigures& figures) {
    const StudyRun& given = study.runs[study.given];
    std::string text =
        study.solved()
            ? fmt::format(
                  "\nErrors of the solution as given, {} elements, by Newton's method; error bars over the range "
                  "of each observable\n",
                  given.elements)
            : fmt::format("\nErrors of the run as given, {} elements and dt = {:.6g} s; error bars over the "
                          "range of each observable, {}\n",
                          given.elements, given.dt,
                          study.at_rest ? "of its end at rest" : "the largest of all samples");
    text += fmt::format("  {:<32}{:>13}{:>13}{:>7}{:>10}{:>10}{:>10}{:>12}  {}\n", "observable", "at the end",
                        "Richardson", "order", "space", "time", "total", "at the end", "convergence");
    for (const ObservableError& o : figures.observables) {
        const auto share = [&](double bar) { return fmt::format("{:.2g}", bar / o.range); };
        text += fmt::format(
            "  {:<32}{:>13.6g}{:>13}{:>7}{:>10}{:>10}{:>10}{:>12}  {}{}\n", fmt::format("{} [{}]", o.name, o.unit),
            o.at_end, o.richardson ? fmt::format("{:.6g}", *o.richardson) : "-", order_text(o),
            share(o.convergence.error_bar.space), share(o.convergence.error_bar.time),
            share(o.convergence.error_bar.total), fmt::format("+-{:.2g}", o.convergence.error_bar_at_end.total),
            verdict(o), o.counts ? "" : " (does not count towards a tolerance)");
    }
    for (const std::string& note : figures.notes) text += "  note: " + note + "\n";
    return text;
}

std::string to_text(const Study& study, const Advice& advice) {
    std::string text;
    const StudyRun& given = study.runs[study.given];
    if (advice.choice) {
        text = fmt::format("For {:g} of the range: {} elements{}, about {:.3g} core-seconds\n", advice.tolerance,
                           advice.choice->elements,
                           study.halves_step() ? fmt::format(" and dt = {:.4g} s", advice.choice->dt) : "",
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
        text += fmt::format("  no numbers for quantities that do not converge smoothly: {}\n",
                            fmt::join(advice.untold, ", "));
    if (advice.by.empty() && advice.untold.empty())
        text += "No observable changes: there is nothing to choose numbers by\n";
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
                        {"as_given", k == study.given},
                        {"core_seconds", figures.core_seconds[k]}});
        if (!study.solved())
            runs.back().update({{"dt_s", r.dt}, {"steps", r.steps}, {"predicted_core_seconds", r.predicted}});
    }
    for (const ObservableError& o : figures.observables) {
        const auto bar = [](const Convergence::ErrorBar& b) {
            return json{{"space", b.space}, {"time", b.time}, {"total", b.total}};
        };
        const Convergence& c = o.convergence;
        observables.push_back(
            {{"name", o.name},
             {"unit", o.unit},
             {"range", o.range},
             {"counts", o.counts},
             {"convergence", nth(smoothness, c.smoothness)},
             {"order", number(c.order)},
             {"at_end", o.end},
             {"richardson_at_end", o.richardson ? json(o.richardson_end) : json(nullptr)},
             {"error_bar", bar(c.error_bar)},
             {"error_bar_at_end", bar(c.error_bar_at_end)},
             {"spread_of_last_two", c.spread},
             {"errors", std::vector(o.error.begin(), o.error.begin() + static_cast<long>(runs.size()))}});
    }
    json out = {{"format", study_format},
                {"version", 1},
                {"title", study.runs[study.given].scene.title},
                {"method", nth(study_method_names, study.method)},
                {"at_rest", study.at_rest},
                {"runs", runs},
                {"observables", observables},
                {"notes", figures.notes}};
    if (advice) {
        out["advice"] = {{"tolerance", advice->tolerance}, {"by", advice->by}, {"untold", advice->untold}};
        if (advice->choice)
            out["advice"].update(
                {{"elements", advice->choice->elements}, {"core_seconds", advice->choice->core_seconds}});
        if (advice->choice && !study.solved()) out["advice"]["dt_s"] = advice->choice->dt;
    }
    return out.dump(2) + "\n";
}

std::string to_csv(const Study& study, const StudyFigures& figures) {
    std::string text = "observable,unit,run,elements,dt[s],core_seconds[s],error,error_over_range\n";
    const double no_step = std::numeric_limits<double>::quiet_NaN();
    for (const ObservableError& o : figures.observables)
        for (std::size_t k = 0; k < study.made().size(); ++k) {
            const StudyRun& r = study.runs[k];
            text +=
                fmt::format("{},{},{},{},{:.17g},{:.6g},{:.6g},{:.6g}\n", o.name, o.unit, r.name, r.elements,
                            study.solved() ? no_step : r.dt, figures.core_seconds[k], o.error[k], o.error[k] / o.range);
        }
    return text;
}

} // namespace skein
