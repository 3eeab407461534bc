#include "core/level.hpp"
#include "core/share_text.hpp"
#include "core/two_digits.hpp"
#include "plan/method_costs.hpp"
#include "plan/plan.hpp"
#include "plan/plan_line.hpp"
#include "plan/plan_words.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace skein {

namespace {

using Json = nlohmann::ordered_json;
using Lines = std::vector<PlanLine>;

std::string checkpoint_text(const Plan& p) {
    std::string text;
    if (p.cadence.checkpoint_wall > 0) text += "every " + duration_text(p.cadence.checkpoint_wall) + " of wall time, ";
    if (p.cadence.of("checkpoint") > 0) text += every(p.cadence.of("checkpoint"), p.dt) + ", ";
    return text + fmt::format("at the end; the newest {} stay{}", p.keeping.newest,
                              p.keeping.milestones ? ", and older ones at doubling ages" : "");
}

/// Work that is lost if the run is killed at the worst moment.
std::string failure_text(const Plan& p) {
    const double steps = static_cast<double>(std::max<std::int64_t>(p.steps, 1)),
                 share = p.cadence.of("checkpoint") > 0 ? static_cast<double>(p.cadence.of("checkpoint")) / steps : 1,
                 predicted = p.predicted_s * std::min(share, 1.0);
    if (p.cadence.checkpoint_wall > 0 && p.cadence.checkpoint_wall < predicted)
        return "costs at most " + duration_text(p.cadence.checkpoint_wall) + " of work";
    return fmt::format("costs at most {} of work, as predicted{}",
                       predicted < 1 ? "a second" : duration_text(predicted), share >= 1 ? ": all there is to do" : "");
}

std::string rods_text(const Plan& p) {
    return fmt::format("{} with {} elements in {}", p.rods, p.elements,
                       counted(static_cast<std::int64_t>(p.groups.size()), "group"));
}

std::string physics_text(const Plan& p) {
    std::vector<std::string> all;
    for (const auto& one : p.physics)
        if (std::string text = one->summary(p); !text.empty()) all.push_back(std::move(text));
    return joined(all, "; ");
}

std::string machine_text(const Machine& m) {
    const std::string chosen = m.lanes < m.most_lanes ? fmt::format(" of {} for few rods", m.most_lanes) : "";
    return fmt::format("{} x {} ({} per rank{}), {}{} ({})", counted(m.ranks, "rank"), counted(m.threads, "thread"),
                       counted(m.cores, "core"), m.which_cores.empty() ? "" : ": " + m.which_cores,
                       counted(m.lanes, "lane"), chosen, level_name(m.lanes));
}

/// Rods or bodies of a group, and where they lie in tiles.
std::string group_text(const GroupPlan& g) {
    const std::string across = g.tiles > 0 ? counted(g.tiles, "tile") : "",
                      along = g.along > 0 ? fmt::format("{} along tiles, {}", counted(g.along, "rod"), g.pieces) : "";
    if (!g.body.empty())
        return fmt::format("{}, {}, each {}", g.rods == 1 ? "1 body" : fmt::format("{} bodies", g.rods), across,
                           g.body);
    return fmt::format("{} x {} elements, {}{}{}, ends {} / {}", counted(g.rods, "rod"), g.elements, across,
                       across.empty() || along.empty() ? "" : " and ", along, g.start, g.end);
}

std::string rotary_text(const GroupPlan& g) {
    const std::string least =
        g.least_rotary_scale < g.largest_rotary_scale ? fmt::format("{:.4g} to ", g.least_rotary_scale) : "";
    return fmt::format("inertia about d1 and d2 times {}{:.4g}, which shifts the lowest bending frequency by {:.2g} %",
                       least, g.largest_rotary_scale, 100 * g.bending_shift);
}

std::string limits_text(const GroupPlan& g) {
    std::vector<std::string> limits;
    for (const TimeLimit& l : g.limits) limits.push_back(fmt::format("{} {:.4g}", l.mode, l.dt));
    return joined(limits, ", ");
}

/// How far resampled rods are from the lines through their points, rounded up.
std::string resampling_text(const Deviation& d) {
    const std::string points =
        d.fewest == d.most ? fmt::format("{}", d.most) : fmt::format("{} to {}", d.fewest, d.most);
    return fmt::format("from {} points each; at most {:.2g} m from the line through them ({})", points,
                       d.distance > 0 ? rounded_up(d.distance) : 0.0, d.rod);
}

/// Lines of a group. Its entries in JSON are those of one object.
Lines describe(const GroupPlan& g, bool pseudo_time) {
    Json limits;
    for (const TimeLimit& l : g.limits) limits[std::string(l.mode)] = {{"dt", l.dt}, {"element", l.element}};
    Lines lines = {{"", "", "name", g.name},
                   {"", "", "rods", g.rods},
                   {"", "", "elements", g.elements},
                   {"", "", "tiles", g.tiles},
                   {"", "", "along", g.along},
                   {"", "", "start", g.start},
                   {"", "", "end", g.end},
                   {fmt::format("group '{}':", g.name), group_text(g), "", {}},
                   {"  passes", joined(g.program.names(), " | "), "passes", g.program.names()},
                   {"  limits [s]", pseudo_time ? "" : limits_text(g), "limits", limits},
                   {"", "", "ns_per_element_step", g.ns_per_element_step}};
    if (g.packed_fill > 0)
        lines.push_back({"  packed",
                         fmt::format("{:.3g} % of the volume of their region, which ends at z = {:.4g} m",
                                     100 * g.packed_fill, g.packed_top),
                         "",
                         {}});
    if (g.deviation.resampled())
        lines.push_back({"  resampled", resampling_text(g.deviation), "resampled",
                         Json{{"deviation", g.deviation.distance},
                              {"rod", g.deviation.rod},
                              {"fewest_points", g.deviation.fewest},
                              {"most_points", g.deviation.most}}});
    lines.push_back({"  rotary", g.largest_rotary_scale > 1 ? rotary_text(g) : "", "rotary_inertia",
                     Json{{"least_scale", g.least_rotary_scale},
                          {"largest_scale", g.largest_rotary_scale},
                          {"bending_shift", g.bending_shift}}});
    if (const auto& chosen = g.automatic_inertia)
        lines.push_back({"", "", "automatic_inertia",
                         Json{{"for_dt", chosen->dt},
                              {"gain", chosen->gain},
                              {"share_of_error", chosen->share},
                              {"highest_mode", chosen->highest},
                              {"frequency_Hz", chosen->frequency}}});
    lines.push_back({"", "", "hints", g.hints});
    for (const std::string& hint : g.hints) lines.push_back({"  hint", hint, "", {}});
    const bool flips = std::isfinite(g.tension_limit);
    lines.push_back({"  tension",
                     flips ? fmt::format("directors flip beyond dilatation e_c = {:.4g}", g.tension_limit) : "",
                     "tension_limit", flips ? Json(g.tension_limit) : Json()});
    return lines;
}

std::string step_text(const Plan& p) {
    const char* automatic = p.automatic_dt ? " (auto)" : "";
    if (p.pseudo_time) return fmt::format("{:g} s: time counts steps of an iteration", p.dt);
    if (p.groups.empty()) return fmt::format("{:.6g} s{}", p.dt, automatic);
    if (is_implicit(p.integrator))
        return fmt::format("{:.6g} s{}, {:.4g} times the limit of explicit steps", p.dt, automatic, p.dt / p.limit);
    return fmt::format("{:.6g} s{}, {} of the limit {:.6g} s ({} of '{}')", p.dt, automatic, share_text(p.dt / p.limit),
                       p.limit, p.groups[p.governing].limits.front().mode, p.groups[p.governing].name);
}

std::string steps_text(const Plan& p) {
    const double steps = static_cast<double>(p.steps), element_steps = steps * static_cast<double>(p.elements);
    return fmt::format("{}  ({:.4g} s{})", p.steps, steps * p.dt,
                       element_steps > 0 ? fmt::format(", {:.3g} element-steps", element_steps) : "");
}

/// End of a stage, and what it changes.
std::string stage_text(const PlannedStage& stage) {
    std::string end = stage.duration > 0 ? fmt::format("for {:g} s", stage.duration) : "";
    if (!stage.until.empty()) end += fmt::format("{}until {}", end.empty() ? "" : ", or ", stage.until);
    if (end.empty()) end = "to the end";
    return stage.changes.empty() ? end : fmt::format("{}: {}", end, joined(stage.changes, "; "));
}

Lines describe_stages(const Plan& p) {
    Lines lines;
    Json json = Json::array();
    for (const PlannedStage& stage : p.stages) {
        lines.push_back({fmt::format("stage '{}':", stage.name), stage_text(stage), "", {}});
        json.push_back(
            {{"name", stage.name}, {"duration", stage.duration}, {"until", stage.until}, {"changes", stage.changes}});
    }
    if (!p.stages.empty()) lines.push_back({"", "", "stages", json});
    return lines;
}

Lines describe_step(const Plan& p) {
    return {{"protocol",
             p.coupling() == PhysicsPlan::Coupling::every_step ? "one step per visit: rods wait for each other" : "",
             "steps_together", p.coupling() != PhysicsPlan::Coupling::none},
            {"integrator",
             p.integrator == Integrator::verlet ? ""
             : is_implicit(p.integrator)        ? std::string(nth(integrator_names, p.integrator))
                                         : fmt::format("{}, limits times {:.4g}", nth(integrator_names, p.integrator),
                                                       scheme_of(p.integrator).stability),
             "integrator", nth(integrator_names, p.integrator)},
            {"dt", step_text(p), "dt", p.dt},
            {"", "", "limit", p.limit},
            {"", "", "automatic_dt", p.automatic_dt},
            {"  divides", p.divides, "divides", p.divides},
            {"", "", "pseudo_time", p.pseudo_time},
            {"", "", "governing_group", p.groups.empty() ? Json() : Json(p.groups[p.governing].name)},
            {"steps", steps_text(p), "steps", p.steps},
            {"ends",
             p.rest_speed > 0 ? fmt::format("at rest, when no node is faster than {:g} m/s", p.rest_speed) : "",
             "",
             {}}};
}

/// Intervals of an output; empty: the run has none of it.
std::string output_text(const Plan& p, std::string_view name) {
    const std::int64_t steps = p.cadence.of(name);
    if (steps == 0) return p.pseudo_time && (name == "trajectory" || name == "series") ? "at the end" : "";
    std::string text = every(steps, p.dt);
    if (name == "trajectory" && p.vtp) text += ", as poly data (rods.pvd) too";
    if (name == "series" && !p.observables.empty()) text += ", with " + joined(p.observables, ", ");
    return text;
}

Lines describe_outputs(const Plan& p) {
    Lines lines;
    Json cadence;
    for (const auto& [name, steps] : p.cadence.steps) {
        cadence[name] = steps;
        const auto describes = [&, of = name](const auto& one) { return one->describes(of); };
        if (name != "checkpoint" && std::none_of(p.physics.begin(), p.physics.end(), describes))
            lines.push_back({name, output_text(p, name), "", {}});
    }
    cadence["checkpoint_wall_s"] = p.cadence.checkpoint_wall;
    lines.push_back({"", "", "cadence", cadence});
    lines.push_back({"checkpoint", checkpoint_text(p), "keep",
                     Json{{"newest", p.keeping.newest}, {"milestones", p.keeping.milestones}}});
    lines.push_back({"a failure", failure_text(p), "", {}});
    lines.push_back({"", "", "vtp", p.vtp});
    lines.push_back({"", "", "observables", p.observables});
    return lines;
}

std::string memory_text(const Plan& p) {
    std::string text = bytes_text(p.state_bytes);
    if (p.elements > 0)
        text += fmt::format(" (rods: {:.0f} B per element)", p.rod_bytes / static_cast<double>(p.elements));
    if (p.copy_bytes > 0) text += fmt::format(", {} for a copy to go back to", bytes_text(p.copy_bytes));
    if (p.frame_bytes > 0) text += fmt::format(", {} for frames that wait", bytes_text(p.frame_bytes));
    text += fmt::format(", {} to disk", bytes_text(p.output_bytes));
    if (p.output_bytes_most > 0) text += fmt::format(", and up to {} more", bytes_text(p.output_bytes_most));
    return text;
}

std::string predicted_text(const Plan& p) {
    std::string text = duration_text(p.predicted_s) + " of stepping";
    if (p.predicted_most_s > 0) text += ", up to " + duration_text(p.predicted_most_s) + " if a bed forms";
    return p.predicted_by.empty() ? text : text + " (timed here: " + p.predicted_by + ")";
}

Lines describe_cost(const Plan& p) {
    return {{"memory", memory_text(p), "state_bytes", p.state_bytes},
            {"", "", "frame_bytes", p.frame_bytes},
            {"", "", "output_bytes", p.output_bytes},
            {"", "", "output_bytes_most", p.output_bytes_most},
            {"predicted", predicted_text(p), "predicted_s", p.predicted_s},
            {"", "", "predicted_most_s", p.predicted_most_s},
            p.methods ? line_of(*p.methods) : PlanLine{}};
}

Lines describe(const Plan& p) {
    Lines lines = {{"", "", "title", p.title},
                   {"rods", p.groups.empty() ? "" : rods_text(p), "rods", p.rods},
                   {"", "", "elements", p.elements},
                   {"runs on", machine_text(p.machine), "machine",
                    Json{{"ranks", p.machine.ranks},
                         {"threads", p.machine.threads},
                         {"cores", p.machine.cores},
                         {"which_cores", p.machine.which_cores},
                         {"lanes", p.machine.lanes},
                         {"level", level_name(p.machine.lanes)}}}};
    Json groups = Json::array();
    const auto append = [&](Lines more) { std::move(more.begin(), more.end(), std::back_inserter(lines)); };
    for (const GroupPlan& g : p.groups) {
        Json& json = groups.emplace_back();
        for (PlanLine& line : describe(g, p.pseudo_time)) {
            if (!line.key.empty()) json[line.key] = std::move(line.json);
            lines.push_back({std::move(line.label), std::move(line.text), "", {}});
        }
    }
    lines.push_back({"", "", "groups", groups});
    for (const auto& one : p.physics) append(one->describe(p));
    append(describe_stages(p));
    append(describe_step(p));
    append(describe_outputs(p));
    append(describe_cost(p));
    lines.push_back({"", "", "notes", p.notes});
    return lines;
}

std::string stages_text(const Plan& p) {
    std::vector<std::string> names;
    for (const PlannedStage& stage : p.stages) names.push_back(stage.name);
    return names.empty() ? "" : "; stages " + joined(names, ", ");
}

/// The plan in brief, with hints as notes.
Lines outline(const Plan& p) {
    std::vector<std::string> outputs;
    for (const auto& [name, steps] : p.cadence.steps)
        if (const std::string text = output_text(p, name); name != "checkpoint" && !text.empty())
            outputs.push_back(fmt::format("{} {}", name, text));
    Lines lines = {{"rods", p.groups.empty() ? "" : rods_text(p), "", {}},
                   {"physics", physics_text(p), "", {}},
                   {"runs on", machine_text(p.machine), "", {}},
                   {"dt", step_text(p), "", {}},
                   {"steps", steps_text(p) + stages_text(p), "", {}},
                   {"output", joined(outputs, "; "), "", {}},
                   {"checkpoint", checkpoint_text(p), "", {}},
                   {"memory", memory_text(p), "", {}},
                   {"predicted", predicted_text(p), "", {}}};
    if (p.methods) lines.push_back(line_of(*p.methods));
    for (const GroupPlan& g : p.groups)
        if (g.deviation.resampled())
            lines.push_back({"resampled", fmt::format("'{}': {}", g.name, resampling_text(g.deviation)), "", {}});
    for (const GroupPlan& g : p.groups)
        for (const std::string& hint : g.hints)
            lines.push_back({"hint", fmt::format("'{}': {}", g.name, hint), "", {}});
    return lines;
}

} // namespace

std::string to_text(const Plan& p, bool all) {
    std::string text = fmt::format("Plan: {}\n", p.title.empty() ? "(untitled)" : p.title);
    const auto print = [&](const std::string& label, const std::string& line) {
        if (!line.empty()) text += fmt::format("  {:<14}{}{}\n", label, label.size() < 14 ? "" : " ", line);
    };
    for (const PlanLine& line : all ? describe(p) : outline(p)) print(line.label, line.text);
    for (const std::string& note : p.notes) print("note", note);
    return text;
}

std::string to_json(const Plan& p) {
    Json json;
    for (PlanLine& line : describe(p))
        if (!line.key.empty()) json[line.key] = line.json.is_null() && !line.text.empty() ? Json(line.text) : line.json;
    return json.dump(2) + "\n";
}

} // namespace skein
