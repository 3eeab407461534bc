#include "physics/fluid/fluid_plan_text.hpp"

#include "fluid/slab_coupling.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "plan/plan_words.hpp"
#include "skein/core/index.hpp"

#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace skein {

std::string fluid_text(const FluidPlan& fluid) {
    const FlowConstants& c = fluid.constants;
    const auto bound = [&](std::size_t d) { return nth(fluid_boundary_names, c.grid.boundary[d]); };
    return fmt::format(
        "{} x {} x {} cells of {:.4g} m, {} / {} / {}, {:.4g} kg/m^3, {:.4g} Pa s; {}, Courant number {:g}{}{}",
        c.grid.cells[0], c.grid.cells[1], c.grid.cells[2], c.grid.h, bound(0), bound(1), bound(2), c.density,
        c.density * c.kinematic_viscosity, nth(flow_scheme_names, c.scheme), fluid.courant,
        c.scheme == FlowScheme::crank_nicolson ? "; viscosity does not limit the step" : "",
        fluid.follows_rods ? "; the box moves along x with the rods" : "");
}

std::string drive_text(const FluidPlan& fluid) {
    const FlowConstants& c = fluid.constants;
    const auto vector = [](const Vec3d& v) { return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", v.x, v.y, v.z); };
    std::vector<std::string> all;
    if (norm(c.acceleration) > 0) all.push_back(fmt::format("acceleration {} m/s^2", vector(c.acceleration)));
    for (std::size_t d = 0; d < 3; ++d)
        for (std::size_t upper = 0; upper < 2; ++upper)
            if (const Vec3d& v = c.wall_velocity[d][upper]; norm(v) > 0)
                all.push_back(fmt::format("{} wall across {} at {} m/s", upper ? "upper" : "lower", direction_names[d],
                                          vector(v)));
    if (all.empty()) return {};
    return joined(all, ", ") + (c.frequency > 0 ? fmt::format("; times cos(2 pi {:.4g} Hz t)", c.frequency) : "");
}

std::string pressure_text(const FluidPlan& fluid, int ranks) {
    const FlowConstants& c = fluid.constants;
    if (c.pressure == PressureMethod::direct && c.exchange == ColumnExchange::transposes) return "direct";
    if (c.pressure == PressureMethod::direct)
        return fmt::format(
            "direct, by numbers at interfaces of slabs{}; other numbers of ranks agree to about 1e-12, not in bits",
            ranks > fluid.across(ranks)
                ? fmt::format(", {:.3g} % of columns through all slabs",
                              100.0 * static_cast<double>(coupling_coefficients(c.grid, ranks / fluid.across(ranks))) /
                                  (1.0 * c.grid.cells[0] * c.grid.cells[1]))
                : "");
    return fmt::format(
        "multigrid to {:g} of the right side, {} ({:.0f} B per cell); bits depend on the number of ranks",
        c.pressure_tolerance, bytes_text(FluidPlan::multigrid_bytes_per_cell * static_cast<double>(c.grid.count())),
        FluidPlan::multigrid_bytes_per_cell);
}

std::string sent_text(const FluidPlan& fluid, int ranks) {
    const std::string ghosts = fmt::format("{} as ghosts", bytes_text(fluid.ghost_bytes(ranks)));
    const int across = fluid.across(ranks);
    const std::string shared = across > 1 ? fmt::format("{} of planes, the rows of each on {} ranks; ",
                                                        counted(ranks / across, "slab"), across)
                                          : std::string();
    if (fluid.constants.pressure != PressureMethod::direct) return fmt::format("by a rank in a step: {}", ghosts);
    const bool whole = fluid.constants.exchange == ColumnExchange::transposes;
    return fmt::format("{}by a rank in a step: {} {} ({} a solve), {}", shared, bytes_text(fluid.column_bytes(ranks)),
                       whole ? "in transposes" : "at interfaces", bytes_text(fluid.solve_bytes(ranks)), ghosts);
}

std::string obstacle_text(const Obstacle& o, const FluidPlan& fluid) {
    const double h = fluid.constants.grid.h;
    const bool round = o.kind == ObstacleKind::sphere || o.kind == ObstacleKind::cylinder;
    const Vec3d sides = (1 / h) * o.sides_of_box();
    const std::string size = round ? fmt::format("{:.3g}", 2 * o.radius / h)
                                   : fmt::format("{:.3g} x {:.3g} x {:.3g}", sides.x, sides.y, sides.z),
                      of = o.mesh ? fmt::format(" of {} triangles,", o.mesh->triangles().size()) : "",
                      moves = o.moves() ? ", moves" : "";
    if (o.is_sharp())
        return fmt::format("'{}', {}{} of {} cells, sharp surface{}", o.name, nth(obstacle_names, o.kind), of, size,
                           moves);
    return fmt::format("'{}', {} of {} cells, {} markers{}; {} sweeps", o.name, nth(obstacle_names, o.kind), size,
                       o.markers(fluid.constants.grid).size(), moves, fluid.forcing.sweeps);
}

std::string rods_in_fluid_text(const RodsInFluid& rods, const FluidPlan& fluid) {
    const auto has = [&](SectionMarkers kind) { return nth(rods.has, kind); };
    const std::string_view one = rods.body ? "body" : "rod";
    std::vector<std::string_view> as;
    if (rods.body) as.emplace_back("its surface");
    if (has(SectionMarkers::ring)) as.emplace_back("rings");
    if (has(SectionMarkers::sheet)) as.emplace_back("sheets");
    if (has(SectionMarkers::centre_line)) as.emplace_back("the centre line, which the fluid sees 1.6 to 2 cells wide");
    const std::string feel =
        fluid.two_way()
            ? fmt::format(
                  "{:.4g} times as heavy as the fluid, which they feel: kicks have {:.3g} of their inertia at least",
                  rods.density_ratio, rods.least_inertia)
            : "they do not feel the fluid";
    if (rods.sharp == 1)
        return fmt::format("'{}', half axes of {:.3g} to {:.3g} cells, a sharp surface; {}", rods.name, rods.least_axis,
                           rods.most_axis, feel);
    const std::string by =
        fluid.forcing.penalty() ? "springs and dampers" : fmt::format("{} sweeps", fluid.forcing.sweeps);
    const std::string sharp =
        rods.sharp > 0 ? fmt::format("a sharp surface along {:.3g} % of the rods, and ", 100 * rods.sharp) : "";
    return fmt::format("'{}', half axes of {:.3g} to {:.3g} cells, {}{} markers a {}, on {}; {}; {}", rods.name,
                       rods.least_axis, rods.most_axis, sharp, rods.markers, one, joined(as, ", "), feel, by);
}

namespace {

double frames_in(const FluidOutput& output, std::int64_t steps) {
    return static_cast<double>(steps / output.every + 1);
}

std::vector<std::string_view> names_of(const FluidOutput& output) {
    std::vector<std::string_view> names;
    for (const CellField field : output.fields) names.push_back(entry_of(field).name);
    return names;
}

} // namespace

std::string output_text(const FluidOutput& o, const FluidGrid& grid, std::int64_t steps, double dt) {
    std::string what = fmt::format("{} x {} x {} cells", o.box.count[0], o.box.count[1], o.box.count[2]);
    if (o.kind == FluidOutputKind::slice)
        what = fmt::format("slice across {}, {}", nth(direction_names, o.across), what);
    if (o.box.average > 1)
        what = fmt::format("{} x {} x {} means over {}^3 cells", o.box.count[0], o.box.count[1], o.box.count[2],
                           o.box.average);
    if (o.kind == FluidOutputKind::blocks)
        what = fmt::format("blocks of {0}^3 cells where {1} exceeds {2:g} {3}", o.edge,
                           o.criterion == CellField::q ? "|q|" : "vorticity", o.threshold, entry_of(o.criterion).unit);
    if (!o.name.empty()) what = fmt::format("'{}', {}", o.name, what);
    const double frames = frames_in(o, steps), most = o.most_bytes(grid);
    const std::string bytes =
        o.kind == FluidOutputKind::blocks
            ? fmt::format("{} a block, up to {:.0f} blocks: up to {} a frame, {} in the run",
                          bytes_text(o.frame_bytes()), o.most_blocks(grid), bytes_text(most), bytes_text(frames * most))
            : fmt::format("{} a frame, {} in the run", bytes_text(most), bytes_text(frames * most));
    return fmt::format("{}: {}; {}; {}", what, joined(names_of(o), ", "), every(o.every, dt), bytes);
}

std::string probe_text(const FluidProbeSpec& probe) {
    return fmt::format("'{}', velocity and pressure at [{:g}, {:g}, {:g}] m", probe.name, probe.at.x, probe.at.y,
                       probe.at.z);
}

std::string fluid_steps_text(const FluidPlan& fluid, std::int64_t steps, double dt) {
    const double all = fluid.steps(steps, dt);
    if (fluid.speed.value == 0)
        return fmt::format("{:.0f} at least: no speed is known, which fluid.expected_speed [m/s] would tell", all);
    return fmt::format("{:.0f}, of a speed of {:.4g} m/s ({}), which is taken to last", all, fluid.speed.value,
                       fluid.speed.by);
}

std::string fluid_cost_text(const FluidPlan& fluid, std::int64_t steps, double dt, int cores, int cores_per_node) {
    const double seconds = fluid.steps(steps, dt) * fluid.step_seconds() / cores, core_hours = seconds * cores / 3600;
    const double step = fluid.step_seconds() / cores;
    std::string text =
        fmt::format("{} a step of the fluid, {}{}; {:.3g} core-hours",
                    step < 1 ? fmt::format("{:.3g} ms", 1e3 * step) : duration_text(step),
                    fluid.speed.value == 0 ? "at least " : "", duration_text(seconds) + " of stepping", core_hours);
    if (cores_per_node > 0) {
        const double nodes = std::ceil(static_cast<double>(cores) / cores_per_node);
        text += fmt::format(", {:.3g} node-hours on {:.0f} node{} of {} cores", nodes * seconds / 3600, nodes,
                            nodes == 1 ? "" : "s", cores_per_node);
    }
    return text;
}

nlohmann::ordered_json fluid_json(const FluidPlan& fluid, std::int64_t steps, double dt, int ranks) {
    nlohmann::ordered_json outputs = nlohmann::ordered_json::array();
    for (const FluidOutput& o : fluid.outputs)
        outputs.push_back({{"name", o.name},
                           {"kind", nth(fluid_output_names, o.kind)},
                           {"fields", names_of(o)},
                           {"every", o.every},
                           {"frames", frames_in(o, steps)},
                           {"most_frame_bytes", o.most_bytes(fluid.constants.grid)}});
    nlohmann::ordered_json probes = nlohmann::ordered_json::array();
    for (const FluidProbeSpec& p : fluid.probes) probes.push_back({{"name", p.name}, {"at", {p.at.x, p.at.y, p.at.z}}});
    nlohmann::ordered_json rods = nlohmann::ordered_json::array();
    for (const RodsInFluid& r : fluid.rods) rods.push_back({{"name", r.name}, {"markers", r.markers}});
    const FlowConstants& c = fluid.constants;
    nlohmann::ordered_json bounds = nlohmann::ordered_json::array();
    for (const FluidBoundary b : c.grid.boundary) bounds.push_back(nth(fluid_boundary_names, b));
    const auto vector = [](const Vec3d& v) { return nlohmann::ordered_json{v.x, v.y, v.z}; };
    nlohmann::ordered_json walls = nlohmann::ordered_json::array();
    for (const auto& [lower, upper] : c.wall_velocity) walls.push_back({vector(lower), vector(upper)});
    return {{"cells", c.grid.cells},
            {"spacing", c.grid.h},
            {"boundaries", bounds},
            {"density", c.density},
            {"kinematic_viscosity", c.kinematic_viscosity},
            {"acceleration", vector(c.acceleration)},
            {"wall_velocities", walls},
            {"frequency", c.frequency},
            {"scheme", nth(flow_scheme_names, c.scheme)},
            {"courant", fluid.courant},
            {"pressure", nth(pressure_method_names, c.pressure)},
            {"pressure_exchange", nth(column_exchange_names, c.exchange)},
            {"pressure_tolerance", c.pressure_tolerance},
            {"ranks_across", fluid.across(ranks)},
            {"bytes_per_cell", fluid.bytes_per_cell(ranks)},
            {"outputs", outputs},
            {"probes", probes},
            {"meets_rods_every", fluid.every},
            {"rods", rods},
            {"speed", fluid.speed.value},
            {"speed_by", fluid.speed.by},
            {"steps", fluid.steps(steps, dt)}};
}

} // namespace skein
