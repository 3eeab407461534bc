#include "scene/plan.hpp"

#include "core/level.hpp"
#include "core/share_text.hpp"
#include "joints/junction.hpp"
#include "loads/plane_friction.hpp"
#include "neighbourhood/exposure.hpp"
#include "physics/fluid/fluid_plan_text.hpp"
#include "physics/plan_words.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace skein {

namespace {

std::string checkpoint_text(const Plan& p) {
    std::string text;
    if (p.cadence.checkpoint_wall > 0) text += "every " + duration_text(p.cadence.checkpoint_wall) + " of wall time, ";
    if (p.cadence.checkpoint > 0) text += every(p.cadence.checkpoint, p.dt) + ", ";
    return text + fmt::format("at the end; the newest {} stay{}", p.keeping.newest,
                              p.keeping.milestones ? ", and older ones at doubling ages" : "");
}

/// Work that is lost if the run is killed at the worst moment.
std::string failure_text(const Plan& p) {
    const double steps = static_cast<double>(std::max<std::int64_t>(p.steps, 1));
    const double share = p.cadence.checkpoint > 0 ? static_cast<double>(p.cadence.checkpoint) / steps : 1;
    const double predicted = p.predicted_s * std::min(share, 1.0);
    if (p.cadence.checkpoint_wall > 0 && p.cadence.checkpoint_wall < predicted)
        return "costs at most " + duration_text(p.cadence.checkpoint_wall) + " of work";
    return fmt::format("costs at most {} of work, as predicted{}",
                       predicted < 1 ? "a second" : duration_text(predicted), share >= 1 ? ": all there is to do" : "");
}

std::string law_text(const ContactLaw& law) {
    std::string text = fmt::format("{} {:.4g}", nth(contact_normal_names, law.normal), law.stiffness);
    if (law.restitution > 0)
        text = fmt::format("{}, restitution {:g} in {:g} s", nth(contact_normal_names, law.normal), law.restitution,
                           law.collision_time);
    else if (law.damping > 0) text += fmt::format(", dashpot {:.4g}", law.damping);
    if (law.friction != ContactFriction::none)
        text += fmt::format(", friction {} {:g} / {:g}", nth(contact_friction_names, law.friction), law.static_friction,
                            law.kinetic());
    if (law.friction == ContactFriction::anisotropic)
        text += fmt::format(" / {:g} / {:g}", law.kinetic_backward, law.kinetic_sideways);
    if (law.soft_until > 0) text += fmt::format(", soft until {:g} s", law.soft_until);
    if (law.friction_from > 0) text += fmt::format(", friction from {:g} s", law.friction_from);
    return text;
}

/// Overlap expected where something presses, and the stiffness that would hold it where that is too far. `only_law`: of
/// all contacts.
std::string overlap_text(const ContactEstimate& estimate, const ContactLaw& law, bool only_law, double assumed) {
    if (estimate.force == 0)
        return fmt::format("neither weight nor a lid presses; the step allows for up to {:g} of the diameter", assumed);
    std::string text =
        fmt::format("{:.2g} of the diameter expected under {:.3g} N ({}); the step allows for up to {:g}",
                    estimate.overlap, estimate.force, estimate.by, assumed);
    const double ratio = estimate.overlap / assumed, power = law.normal == ContactNormal::linear ? 1 : 1.5;
    if (ratio <= 1) return text;
    const double times = std::pow(ratio, power);
    if (only_law && law.restitution == 0)
        text += fmt::format(", which stiffness = {:.2g} would hold", times * law.stiffness);
    else text += fmt::format(", which {:.2g} times the stiffness would hold", times);
    return text;
}

std::string wall_text(const Wall& wall, double overlap) {
    std::string text = fmt::format("'{}', {}, {}", wall.name, nth(wall_names, wall.kind), law_text(wall.law));
    if (wall.servo.drives())
        text += fmt::format("; driven at {:g} m/s by the stress on '{}'", wall.servo.speed, wall.servo.watch);
    else if (wall.moves_steadily()) text += "; moves";
    if (overlap > 0) text += fmt::format("; overlap of {:.2g} expected", overlap);
    return text;
}

std::string joint_text(const JointSpec& joint, std::size_t count) {
    const JointLaw& law = joint.law;
    std::string text =
        fmt::format("{} {}, '{}' to '{}', ", count, nth(joint_names, joint.kind), joint.between[0], joint.between[1]);
    if (!shares_node(joint)) text += fmt::format("k {:.4g} N/m", law.stiffness);
    else text += turns_by_half_cells(joint) ? "as within a rod" : "a common node";
    if (law.damping > 0) text += fmt::format(", dashpot {:.4g} N s/m", law.damping);
    if (law.torsional_stiffness > 0) text += fmt::format(", torsional {:.4g} N m/rad", law.torsional_stiffness);
    if (law.torsional_damping > 0) text += fmt::format(", {:.4g} N m s/rad", law.torsional_damping);
    if (law.repulsion > 0) text += fmt::format(", repulsion {:.4g} N/m^1.5", law.repulsion);
    return text;
}

/// Between the passes before `expose` and those after it.
std::string coupling_text(const Plan& p) {
    std::string text =
        p.machine.ranks > 1 ? fmt::format("ghosts, {} B each", Exposure::sent_numbers_per_slot * sizeof(double)) : "";
    for (const InteractionSpec& interaction : p.interactions) {
        text += fmt::format("{}{}", text.empty() ? "" : " | ", name_of(interaction));
        if (const double ns = predicted_ns(interaction); ns > 0) text += fmt::format(", {:g} ns an element", ns);
    }
    return text;
}

} // namespace

std::string to_text(const Plan& p) {
    std::string text;
    const auto out = std::back_inserter(text);
    const auto line = [&](const char* label, const std::string& value) {
        fmt::format_to(out, "  {:<14}{}\n", label, value);
    };

    fmt::format_to(out, "Plan: {}\n", p.title.empty() ? "(untitled)" : p.title);
    if (!p.groups.empty())
        line("rods", fmt::format("{} with {} elements in {}", p.rods, p.elements,
                                 counted(static_cast<std::int64_t>(p.groups.size()), "group")));
    if (p.fluid) line("fluid", fluid_text(*p.fluid));
    if (p.fluid)
        if (const std::string drive = drive_text(*p.fluid); !drive.empty()) line("  driven by", drive);
    if (p.fluid) line("  pressure", pressure_text(*p.fluid, p.machine.ranks));
    if (p.fluid && p.machine.ranks > 1) line("  sent", sent_text(*p.fluid, p.machine.ranks));
    if (p.fluid)
        for (const Obstacle& o : p.fluid->obstacles) line("  obstacle", obstacle_text(o, *p.fluid));
    if (p.fluid)
        for (const RodsInFluid& rods : p.fluid->rods) line("  rods", rods_in_fluid_text(rods, *p.fluid));
    if (p.events_every() > 1)
        line("  meets rods",
             fmt::format(
                 "every {} steps of rods, {:.4g} s: a step of the fluid, or up to {} where it has to be shorter{}",
                 p.events_every(), static_cast<double>(p.events_every()) * p.dt, p.fluid->most_parts(),
                 p.fluid->largest_slip > 0
                     ? fmt::format(", as for slips above {:g} of the speed", p.fluid->largest_slip)
                     : ""));
    line("runs on", fmt::format("{} x {} ({} per rank{}), {} ({})", counted(p.machine.ranks, "rank"),
                                counted(p.machine.threads, "thread"), counted(p.machine.cores, "core"),
                                p.machine.which_cores.empty() ? "" : ": " + p.machine.which_cores,
                                counted(p.machine.lanes, "lane"), level_name(p.machine.lanes)));
    for (const GroupPlan& g : p.groups) {
        const std::string across = g.tiles > 0 ? counted(g.tiles, "tile") : "",
                          along =
                              g.along > 0 ? fmt::format("{} along tiles, {}", counted(g.along, "rod"), g.pieces) : "";
        if (!g.body.empty())
            fmt::format_to(out, "  group '{}': {}, {}, each {}\n", g.name,
                           g.rods == 1 ? "1 body" : fmt::format("{} bodies", g.rods), across, g.body);
        else
            fmt::format_to(out, "  group '{}': {} x {} elements, {}{}{}, ends {} / {}\n", g.name,
                           counted(g.rods, "rod"), g.elements, across, across.empty() || along.empty() ? "" : " and ",
                           along, g.start, g.end);
        line("  passes", fmt::format("{}", fmt::join(g.program.names(), " | ")));
        std::vector<std::string> limits;
        for (const TimeLimit& l : g.limits) limits.push_back(fmt::format("{} {:.4g}", l.mode, l.dt));
        if (!p.relax) line("  limits [s]", joined(limits, ", ")); // of motion
        if (g.packed_fill > 0)
            line("  packed", fmt::format("{:.3g} % of the volume of their region, which ends at z = {:.4g} m",
                                         100 * g.packed_fill, g.packed_top));
        if (g.largest_rotary_scale > 1) {
            const std::string least =
                g.least_rotary_scale < g.largest_rotary_scale ? fmt::format("{:.4g} to ", g.least_rotary_scale) : "";
            line("  rotary",
                 fmt::format(
                     "inertia about d1 and d2 times {}{:.4g}, which shifts the lowest bending frequency by {:.2g} %",
                     least, g.largest_rotary_scale, 100 * g.bending_shift));
        }
        for (const Load& load : g.loads)
            if (const auto* plane = load.get_if<PlaneFriction>())
                line("  plane",
                     fmt::format("elements touch it up to a gap of {:.3g} m; what slips slower than {:.3g} m/s is held",
                                 plane->tolerance, plane->slip_speed));
        for (const std::string& hint : g.hints) line("  hint", hint);
        if (std::isfinite(g.tension_limit))
            line("  tension", fmt::format("directors flip beyond dilatation e_c = {:.4g}", g.tension_limit));
    }
    for (const AssemblyPlan& a : p.assemblies) {
        line("assembly",
             fmt::format("'{}': {}, of {} with {} elements and {}", a.name,
                         a.copies == 1 ? "1 copy" : fmt::format("{} copies", a.copies), counted(a.rods, "rod"),
                         a.elements, counted(static_cast<std::int64_t>(a.joints.size()), "joint")));
        for (std::size_t t = 0; t < a.joints_of_table.size(); ++t)
            if (a.joints_of_table[t] > 0) line("  joints", joint_text(p.joints[t], a.joints_of_table[t]));
    }
    if (p.contact) {
        line("contact", law_text(p.contact->law) + (p.automatic_stiffness ? " (auto)" : "") +
                            (p.contact->self ? ", of rods with themselves too" : ""));
        line("  overlap",
             overlap_text(p.estimate, p.contact->law, p.contact_laws->materials() == 1, p.contact->overlap));
    }
    for (std::size_t w = 0; w < p.walls.size(); ++w) line("wall", wall_text(p.walls[w], p.estimate.wall_overlaps[w]));
    const bool servos =
        std::any_of(p.walls.begin(), p.walls.end(), [](const Wall& wall) { return wall.servo.drives(); });
    if (p.contact || servos) line("protocol", "one step per visit: rods wait for each other");
    else if (is_coupled(p) && !p.groups.empty()) line("protocol", "rods by themselves until the fluid meets them");
    if (p.contact) line("coupling", coupling_text(p));
    if (p.integrator != Integrator::verlet)
        line("integrator", fmt::format("{}, limits times {:.4g}", nth(integrator_names, p.integrator),
                                       scheme_of(p.integrator).stability));
    if (p.relax)
        line("dt", fmt::format(
                       "1 s: rods relax, time counts steps; they have settled when none wants a correction beyond {:g}",
                       p.relax_tolerance));
    else if (p.groups.empty())
        line("dt", fmt::format("{:.6g} s{}, which the fluid divides as its velocities want", p.dt,
                               p.automatic_dt ? " (auto)" : ""));
    else
        line("dt", fmt::format("{:.6g} s{}, {} of the limit {:.6g} s ({} of '{}')", p.dt,
                               p.automatic_dt ? " (auto)" : "", share_text(p.dt / p.limit), p.limit,
                               p.groups[p.governing].limits.front().mode, p.groups[p.governing].name));
    if (p.automatic_dt && p.dt > 0.5 * p.speeds.longest_step() && !p.relax)
        line("  speeds",
             fmt::format("{} may meet at {:.3g} m/s, {:.3g} of the diameter in a step; {:g} is allowed for",
                         p.speeds.fastest.who, p.speeds.fastest.speed,
                         p.speeds.fastest.speed * p.dt / p.speeds.fastest.diameter, p.speeds.fastest.allowed));
    if (!p.divides.empty()) line("  divides", p.divides);
    line("steps", fmt::format("{}  ({:.4g} s, {:.3g} element-steps)", p.steps, static_cast<double>(p.steps) * p.dt,
                              static_cast<double>(p.steps) * static_cast<double>(p.elements)));
    const auto interval = [&p](std::int64_t steps) {
        return steps == 0 && p.relax ? "at the end" : every(steps, p.dt);
    };
    line("trajectory", interval(p.cadence.trajectory) + (p.vtp ? ", as poly data (rods.pvd) too" : ""));
    line("tips", every(p.cadence.tips, p.dt));
    line("series", interval(p.cadence.series) + (p.observables.empty() ? "" : ", with " + joined(p.observables, ", ")));
    if (p.fluid)
        for (const FluidOutput& o : p.fluid->outputs)
            line("fluid output", output_text(o, p.fluid->constants.grid, p.steps, p.dt));
    if (p.cadence.contacts > 0) line("contacts", every(p.cadence.contacts, p.dt));
    if (p.rest_speed > 0) line("ends", fmt::format("at rest, when no node is faster than {:g} m/s", p.rest_speed));
    line("checkpoint", checkpoint_text(p));
    line("a failure", failure_text(p));
    if (p.groups.empty())
        line("memory",
             fmt::format("{} ({:.0f} B per cell), {} to disk", bytes_text(p.state_bytes),
                         p.fluid->bytes_per_cell(p.machine.ranks), bytes_text(p.output_bytes)) +
                 (p.most_block_bytes > 0 ? fmt::format(", and up to {} of blocks", bytes_text(p.most_block_bytes))
                                         : ""));
    else
        line("memory",
             fmt::format(
                 "{} for {}{}{}, {} to disk", bytes_text(p.state_bytes),
                 p.fluid ? fmt::format("rods and fluid ({:.0f} B per cell)", p.fluid->bytes_per_cell(p.machine.ranks))
                         : fmt::format("rods ({:.0f} B per element)", p.state_bytes / static_cast<double>(p.elements)),
                 p.copy_bytes > 0 ? fmt::format(", {} for a copy to go back to", bytes_text(p.copy_bytes)) : "",
                 p.frame_bytes > 0 ? fmt::format(", {} for frames that wait", bytes_text(p.frame_bytes)) : "",
                 bytes_text(p.output_bytes)));
    for (const std::string& note : p.notes) line("note", note);
    if (p.fluid) {
        const int cores = p.machine.ranks * std::min(p.machine.threads, p.machine.cores);
        line("fluid steps", fluid_steps_text(*p.fluid, p.steps, p.dt));
        line("predicted", fluid_cost_text(*p.fluid, p.steps, p.dt, cores, p.machine.cores_per_node));
    }
    if (!p.groups.empty()) line("predicted", fmt::format("{} of stepping", duration_text(p.predicted_s)));
    line("not here", joined(p.absent, ", "));
    return text;
}

std::string to_json(const Plan& p) {
    nlohmann::ordered_json groups = nlohmann::ordered_json::array();
    for (const GroupPlan& g : p.groups) {
        nlohmann::ordered_json limits;
        for (const TimeLimit& l : g.limits) limits[std::string(l.mode)] = {{"dt", l.dt}, {"element", l.element}};
        groups.push_back({{"name", g.name},
                          {"rods", g.rods},
                          {"elements", g.elements},
                          {"tiles", g.tiles},
                          {"along", g.along},
                          {"start", g.start},
                          {"end", g.end},
                          {"passes", g.program.names()},
                          {"limits", limits},
                          {"ns_per_element_step", g.ns_per_element_step},
                          {"hints", g.hints},
                          {"rotary_inertia",
                           {{"least_scale", g.least_rotary_scale},
                            {"largest_scale", g.largest_rotary_scale},
                            {"bending_shift", g.bending_shift}}},
                          {"tension_limit", std::isfinite(g.tension_limit) ? nlohmann::ordered_json(g.tension_limit)
                                                                           : nlohmann::ordered_json()}});
    }
    nlohmann::ordered_json walls = nlohmann::ordered_json::array();
    for (std::size_t w = 0; w < p.walls.size(); ++w) {
        const Wall& wall = p.walls[w];
        walls.push_back({{"name", wall.name},
                         {"kind", nth(wall_names, wall.kind)},
                         {"law", law_text(wall.law)},
                         {"driven", wall.servo.drives()},
                         {"moves", wall.moves_steadily()},
                         {"expected_overlap", p.estimate.wall_overlaps[w]}});
    }
    nlohmann::ordered_json coupling = nlohmann::ordered_json::array();
    for (const InteractionSpec& interaction : p.interactions) coupling.push_back(name_of(interaction));
    const nlohmann::ordered_json json = {
        {"title", p.title},
        {"machine",
         {{"ranks", p.machine.ranks},
          {"threads", p.machine.threads},
          {"cores", p.machine.cores},
          {"which_cores", p.machine.which_cores},
          {"lanes", p.machine.lanes},
          {"level", level_name(p.machine.lanes)}}},
        {"rods", p.rods},
        {"elements", p.elements},
        {"groups", groups},
        {"contact", p.contact ? nlohmann::ordered_json(law_text(p.contact->law)) : nlohmann::ordered_json()},
        {"contact_estimate", p.contact ? nlohmann::ordered_json{{"stiffness", p.contact->law.stiffness},
                                                                {"automatic", p.automatic_stiffness},
                                                                {"force_N", p.estimate.force},
                                                                {"by", p.estimate.by},
                                                                {"expected_overlap", p.estimate.overlap},
                                                                {"overlap_of_step", p.contact->overlap}}
                                       : nlohmann::ordered_json()},
        {"fluid", p.fluid ? fluid_json(*p.fluid, p.steps, p.dt, p.machine.ranks) : nlohmann::ordered_json()},
        {"walls", walls},
        {"steps_together", is_coupled(p)},
        {"coupling", coupling},
        {"dt", p.dt},
        {"limit", p.limit},
        {"automatic_dt", p.automatic_dt},
        {"divides", p.divides},
        {"relax", p.relax},
        {"integrator", nth(integrator_names, p.integrator)},
        {"governing_group",
         p.groups.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(p.groups[p.governing].name)},
        {"steps", p.steps},
        {"cadence",
         {{"trajectory", p.cadence.trajectory},
          {"tips", p.cadence.tips},
          {"series", p.cadence.series},
          {"checkpoint", p.cadence.checkpoint},
          {"checkpoint_wall_s", p.cadence.checkpoint_wall}}},
        {"keep", {{"newest", p.keeping.newest}, {"milestones", p.keeping.milestones}}},
        {"vtp", p.vtp},
        {"observables", p.observables},
        {"state_bytes", p.state_bytes},
        {"frame_bytes", p.frame_bytes},
        {"output_bytes", p.output_bytes},
        {"most_block_bytes", p.most_block_bytes},
        {"predicted_s", p.predicted_s},
        {"notes", p.notes},
        {"absent", p.absent}};
    return json.dump(2) + "\n";
}

} // namespace skein
