#include "simulation/summary.hpp"

#include "io/files.hpp"
#include "io/series_names.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>

namespace skein {

namespace {

double element_steps(const RunFigures& f) {
    return static_cast<double>(f.result.step - f.end.first_step) * static_cast<double>(f.plan.elements);
}

/// Wall time of the steps per element-step, with all that rods exert on each other, times the cores at work on it.
double ns_per_element_step(const RunFigures& f) {
    const double cores = f.plan.machine.ranks * std::min(f.plan.machine.threads, f.plan.machine.cores);
    const double steps = element_steps(f);
    double seconds = 0;
    for (const Phase phase : {Phase::rods, Phase::exchange, Phase::search, Phase::contacts, Phase::balance})
        seconds += nth(f.phases, phase).max;
    return steps > 0 ? seconds * cores * 1e9 / steps : 0;
}

double ns_per_cell_step(const RunFigures& f) {
    const double cores = f.plan.machine.ranks * std::min(f.plan.machine.threads, f.plan.machine.cores);
    const double seconds = // means: ranks that have no markers wait in steps of the fluid for those that have
        nth(f.phases, Phase::fluid).mean + nth(f.phases, Phase::markers).mean;
    return seconds * cores * 1e9 / f.cell_steps;
}

nlohmann::ordered_json ghosts_json(const std::vector<GhostFigures>& ghosts) {
    const auto of_ranks = [&](std::int64_t GhostFigures::*of) {
        std::vector<std::int64_t> values;
        for (const GhostFigures& rank : ghosts) values.push_back(rank.*of);
        return values;
    };
    return {{"rods", of_ranks(&GhostFigures::bodies)},
            {"elements", of_ranks(&GhostFigures::elements)},
            {"neighbours", of_ranks(&GhostFigures::neighbours)},
            {"messages", of_ranks(&GhostFigures::messages)},
            {"bytes", of_ranks(&GhostFigures::bytes)}};
}

std::vector<double> waits(const std::vector<WaitFigures>& ranks, double WaitFigures::*of) {
    std::vector<double> seconds;
    for (const WaitFigures& rank : ranks) seconds.push_back(rank.*of);
    return seconds;
}

/// Waits of ranks, and the rank that others wait for.
std::string waits_text(const std::vector<WaitFigures>& ranks) {
    const auto most = [&](double WaitFigures::*of) { return std::ranges::max(waits(ranks, of)); };
    const auto all = [](const WaitFigures& w) { return w.vote + w.ghosts + w.rebuild; };
    const auto busiest = std::ranges::min_element(ranks, {}, all);
    return fmt::format(
        "waits of a rank, at most: {:.3g} s for votes on lists, {:.3g} s for ghosts, {:.3g} s at rebuilds; "
        "rank {} waits least, {:.3g} s in all\n",
        most(&WaitFigures::vote), most(&WaitFigures::ghosts), most(&WaitFigures::rebuild), busiest - ranks.begin(),
        all(*busiest));
}

} // namespace

std::string digest_text(std::uint64_t digest) { return fmt::format("{:016x}", digest); }

std::int64_t resident_bytes() {
    long pages = 0;
    if (std::FILE* statm = std::fopen("/proc/self/statm", "r")) {
        if (std::fscanf(statm, "%*s %ld", &pages) != 1) pages = 0;
        std::fclose(statm);
    }
    return static_cast<std::int64_t>(pages) * sysconf(_SC_PAGESIZE);
}

std::string summary_json(const RunFigures& f) {
    nlohmann::ordered_json phases, observables, overlaps = nlohmann::ordered_json::object();
    for (std::size_t p = 0; p < phase_count; ++p)
        phases[std::string(phase_names[p])] = {
            {"min_s", f.phases[p].min}, {"mean_s", f.phases[p].mean}, {"max_s", f.phases[p].max}};
    for (const LargestOverlap& o : f.overlaps) overlaps[o.of == "rods" ? "rods" : "wall " + o.of] = o.overlap;
    for (std::size_t i = 0; i < f.end.names.size(); ++i) observables[f.end.names[i]] = f.end.observables[i];
    nlohmann::ordered_json json = {
        {"version", SKEIN_VERSION},
        {"title", f.plan.title},
        {"finished", f.end.finished},
        {"digest", digest_text(f.result.digest)},
        {"steps", f.result.step},
        {"first_step", f.end.first_step},
        {"time_s", f.time_s},
        {"dt_s", f.plan.dt},
        {"dt_limit_s", f.plan.limit},
        {"rods", f.plan.rods},
        {"elements", f.plan.elements},
        {"element_steps", element_steps(f)},
        {"wall_s", f.end.wall_s},
        {"ns_per_element_step", ns_per_element_step(f)},
        {"predicted_s", f.plan.predicted_s},
        {"ranks", f.plan.machine.ranks},
        {"threads", f.plan.machine.threads},
        {"cores_per_rank", f.plan.machine.cores},
        {"lanes", f.plan.machine.lanes},
        {"protocol", nth(protocol_names, f.protocol)},
        {"largest_overlap", overlaps},
        {"phases", phases},
        {"fluid_cell_steps", f.cell_steps},
        {"memory",
         {{"rods_bytes", f.rod_bytes},
          {"rods_bytes_per_element",
           static_cast<double>(f.rod_bytes) / std::max(1.0, static_cast<double>(f.plan.elements))},
          {"resident_bytes", f.resident_bytes}}},
        {"output", nlohmann::ordered_json::parse(f.end.texts.output)},
        {"series_format", series_format},
        {"observables", observables}};
    if (f.slips)
        json["slip"] = {{"slip", f.slips->slip},
                        {"share", f.slips->share},
                        {"largest_share", f.slips->largest_share},
                        {"allowed", f.slips->allowed},
                        {"warning", f.slip_warning}};
    if (!f.ghosts.empty()) {
        json["ghosts"] = ghosts_json(f.ghosts);
        json["waits"] = {{"votes_s", waits(f.waits, &WaitFigures::vote)},
                         {"ghosts_s", waits(f.waits, &WaitFigures::ghosts)},
                         {"rebuilds_s", waits(f.waits, &WaitFigures::rebuild)}};
        json["balance"] = {
            {"migrations", f.balance.migrations}, {"rods", f.balance.bodies}, {"imbalance", f.balance.imbalance}};
    }
    json.update(nlohmann::ordered_json::parse(f.interactions));
    if (!f.end.texts.ancestry.empty()) json["ancestry"] = nlohmann::ordered_json::parse(f.end.texts.ancestry);
    return json.dump(2) + "\n";
}

RunFigures figures_of(const World& world, const RunResult& result, RunEnd end) {
    const Communicator& comm = world.comm;
    const Interactions& all = world.interactions();
    RunFigures figures{.plan = world.plan,
                       .result = result,
                       .end = std::move(end),
                       .time_s = world.clock.time(),
                       .protocol = world.protocol(),
                       .phases = {}};
    for (std::size_t p = 0; p < phase_count; ++p) {
        const double mine = world.timers.seconds(static_cast<Phase>(p)),
                     sum = static_cast<double>(comm.sum(std::llround(mine * 1e6))) * 1e-6;
        figures.phases.push_back({comm.min(mine), sum / comm.size(), comm.max(mine)});
    }
    figures.rod_bytes = comm.sum(static_cast<std::int64_t>(world.rods().bytes()));
    figures.resident_bytes = comm.sum(resident_bytes());
    figures.overlaps = largest_overlaps(comm, all);
    if (const FluidInteraction* fluid = fluid_of(all)) {
        figures.cell_steps = fluid->cell_steps();
        figures.speed_to_expect = fluid->speed_to_expect();
        figures.slips = fluid->slips();
        figures.slip_warning = fluid->warning();
    }
    if (world.neighbourhood() && comm.size() > 1) {
        figures.ghosts = world.neighbourhood()->figures_of_ranks();
        figures.waits = world.neighbourhood()->waits_of_ranks();
        figures.balance = world.balance().figures();
    }
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    for (const auto& interaction : all)
        if (!world.solved()) interaction->summarise(json);
    figures.interactions = json.dump();
    return figures;
}

std::string output_json(const SceneSpec& scene) {
    return nlohmann::json::parse(scene_json(scene, false))["output"].dump();
}

EarlierSummary read_summary(const std::string& path, std::uint64_t digest, const std::string& output) {
    using nlohmann::json;
    if (!std::filesystem::is_regular_file(path)) return {};
    const json summary = json::parse(read_file(path), nullptr, false);
    if (!summary.is_object() || summary.value("digest", json()) != digest_text(digest)) return {};
    EarlierSummary earlier{.ended = true, .changes = {}};
    if (!summary.contains("output")) return earlier;
    const json was = json{{"output", summary["output"]}}.flatten(),
               now = json{{"output", json::parse(output)}}.flatten();
    json all = was;
    all.update(now);
    for (const auto& item : all.items()) {
        const auto in = [&](const json& table) {
            return table.contains(item.key()) ? table[item.key()].dump() : "absent";
        };
        if (in(was) != in(now)) earlier.changes += fmt::format("\n  {}: was {}, now {}", item.key(), in(was), in(now));
    }
    return earlier;
}

std::string timing_table(const RunFigures& f) {
    std::string text = fmt::format("\n{:<12}{:>10}{:>10}{:>10}{:>9}\n", "phase", "min s", "mean s", "max s", "share");
    const auto out = std::back_inserter(text);
    double sum = 0;
    for (std::size_t p = 0; p < phase_count; ++p) {
        if (f.phases[p].max < 5e-4) continue; // not there, or 0 as it would be told
        fmt::format_to(out, "{:<12}{:>10.3f}{:>10.3f}{:>10.3f}{:>8.1f}%\n", phase_names[p], f.phases[p].min,
                       f.phases[p].mean, f.phases[p].max, 100 * f.phases[p].mean / f.end.wall_s);
        sum += f.phases[p].mean;
    }
    fmt::format_to(out, "{:<12}{:>10}{:>10.3f}{:>10}{:>8.1f}%\n", "other", "", f.end.wall_s - sum, "",
                   100 * (f.end.wall_s - sum) / f.end.wall_s);
    fmt::format_to(out, "{:<12}{:>10}{:>10.3f}\n\n", "total", "", f.end.wall_s);
    if (f.cell_steps > 0)
        fmt::format_to(out, "{:.4g} cell-steps of the fluid, {:.1f} ns each and core\n", f.cell_steps,
                       ns_per_cell_step(f));
    if (f.speed_to_expect > 0)
        fmt::format_to(out,
                       "some steps of the fluid were cut in parts; with fluid.expected_speed = {:g} none would be\n",
                       0.1 * std::ceil(10 * f.speed_to_expect));
    if (f.slips)
        fmt::format_to(out,
                       "slip at markers {:.2g} of the largest speed at the end, {:.2g} at most; {:g} is aimed at; ways "
                       "of rods are "
                       "wrong by some ten times as much\n",
                       f.slips->share, f.slips->largest_share, f.slips->allowed);
    if (f.plan.elements == 0)
        return text + fmt::format("{:.1f} MB resident\n", static_cast<double>(f.resident_bytes) * 1e-6);
    fmt::format_to(out,
                   "{:.4g} element-steps, {:.1f} ns each and core; {:.0f} B per element for rods, {:.1f} MB resident\n",
                   element_steps(f), ns_per_element_step(f),
                   static_cast<double>(f.rod_bytes) / static_cast<double>(f.plan.elements),
                   static_cast<double>(f.resident_bytes) * 1e-6);
    for (const LargestOverlap& o : f.overlaps)
        if (o.overlap > 0)
            fmt::format_to(out, "largest overlap {} {:.3g} of the diameter; the step allows for {:g}\n",
                           o.of == "rods" ? "of rods" : fmt::format("with wall '{}'", o.of), o.overlap, o.allowed);
    if (!f.ghosts.empty()) {
        GhostFigures most;
        for (const GhostFigures& rank : f.ghosts)
            for (const auto of : {&GhostFigures::bodies, &GhostFigures::elements, &GhostFigures::neighbours,
                                  &GhostFigures::messages, &GhostFigures::bytes})
                most.*of = std::max(most.*of, rank.*of);
        fmt::format_to(
            out,
            "ghosts of a rank, at most: {} elements of {} rods, {} neighbours; {} messages with {} bytes sent a step\n",
            most.elements, most.bodies, most.neighbours, most.messages, most.bytes);
        text += waits_text(f.waits);
        if (f.balance.imbalance > 0)
            fmt::format_to(
                out, "cost of the busiest rank {:.3g} of the mean; rods went to other ranks {} times, {} in all\n",
                f.balance.imbalance, f.balance.migrations, f.balance.bodies);
    }
    fmt::format_to(out, "step {}  digest {}\n", f.result.step, digest_text(f.result.digest));
    return text;
}

} // namespace skein
