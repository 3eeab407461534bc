#include "core/nearest.hpp"
#include "fluid/cell_fields.hpp"
#include "fluid/start_velocity.hpp"
#include "formula/formula.hpp"
#include "physics/fluid/fitted_fluid.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "physics/group_names.hpp"
#include "physics/scene_spec.hpp"
#include "physics/table_objections.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr long most_cells = 16384; ///< along a direction
constexpr long least_between_walls = 4;

void check_cells(const FluidSpec& fluid, Objections& table) {
    const std::array bounds = fluid.boundaries();
    if (fluid.cells.empty() && fluid.fitted()) return; // what no box could be fitted to has been told
    if (fluid.cells.empty())
        return table.add("", "'cells' along x, y and z are needed, or 'margin_lower' [m] around the rods");
    table.length("cells", fluid.cells.size(), 3, "along x, y and z");
    for (std::size_t d = 0; d < std::min<std::size_t>(3, fluid.cells.size()); ++d) {
        const long n = fluid.cells[d];
        const std::string key = fmt::format("cells.{}", d);
        if (n < 1 || n > most_cells)
            table.add(key, fmt::format("{} cells along {}: from 1 to {} are possible", n, "xyz"[d], most_cells));
        else if (!is_smooth(n) && fluid.pressure == PressureMethod::direct)
            table.add(key,
                      fmt::format(
                          "{} cells along {} are no product of 2, 3, 5 and 7; {} would do, or pressure = \"multigrid\"",
                          n, "xyz"[d], next_smooth(n)));
        else if (bounds[d] != FluidBoundary::periodic && n < least_between_walls)
            table.add(key, fmt::format("{} cells along {}, which is not periodic, are too few: at least {}", n,
                                       "xyz"[d], least_between_walls));
    }
}

/// As far as it is known without the number of ranks.
void check_ranks(const FluidSpec& fluid, Objections& table) {
    if (fluid.ranks_across <= 1) return;
    if (fluid.pressure == PressureMethod::multigrid)
        table.add("ranks_across",
                  "multigrid needs whole planes: 'ranks_across' must be 1 with pressure = \"multigrid\"");
    if (fluid.cells.size() != 3) return;
    const long most = std::max(1L, fluid.cells[1] / FieldLayout::ghosts);
    if (fluid.ranks_across > most)
        table.add("ranks_across",
                  fmt::format("{} rows of cells along y are too few for {} ranks: at most {} can share them",
                              fluid.cells[1], fluid.ranks_across, most));
}

/// Checks the walls that move.
void check_walls(const FluidSpec& fluid, Objections& table) {
    const std::array bounds = fluid.boundaries();
    const auto no_slip = [&](int d) { return nth(bounds, d) == FluidBoundary::no_slip; };
    const bool moves = norm(fluid.lower_wall_velocity) > 0 || norm(fluid.upper_wall_velocity) > 0;
    const int across = fluid.moving_direction(), sets = no_slip(0) + no_slip(1) + no_slip(2);
    if (!moves && norm(fluid.acceleration) == 0) table.unused({"frequency"}, "where nothing drives the fluid");
    if (sets == 0)
        return table.unused({"lower_wall_velocity", "upper_wall_velocity", "moving_walls"},
                            "without \"no_slip\" walls");
    if (across >= 0 && !no_slip(across))
        return table.add("moving_walls",
                         fmt::format("there are no walls across {0}: along_{0} is not \"no_slip\"", "xyz"[across]));
    if (!moves) return table.unused({"moving_walls"}, "without 'lower_wall_velocity' or 'upper_wall_velocity'");
    for (const auto& [key, velocity] : {std::pair{"lower_wall_velocity", fluid.lower_wall_velocity},
                                        std::pair{"upper_wall_velocity", fluid.upper_wall_velocity}}) {
        if (across < 0 && norm(velocity) > 0)
            table.add(key,
                      fmt::format("walls across {} directions are \"no_slip\": 'moving_walls' says which of them move",
                                  sets));
        if (across >= 0 && component_of(velocity, across) != 0)
            table.add(
                key,
                fmt::format("walls across {0} move along themselves alone: the {0} component must be 0, not {1:g} m/s",
                            "xyz"[across], component_of(velocity, across)));
    }
}

/// Keys of a shape that other shapes do not use, and those that it needs.
void check_shape(const Obstacle& o, const FluidSpec& fluid, Objections& table) {
    using enum ObstacleKind;
    const std::string of = fmt::format("of kind \"{}\"", nth(obstacle_names, o.kind));
    const auto keys_of = [&](const std::string& key) -> std::vector<ObstacleKind> {
        if (key == "radius") return {sphere, cylinder, capsule, box};
        if (key == "second_radius") return {cylinder};
        if (key == "length") return {capsule};
        if (key == "sides") return {box};
        if (key == "half_axes") return {ellipsoid};
        if (key == "axis") return {capsule, box, ellipsoid, mesh};
        if (key == "normal") return {cylinder, box, ellipsoid, mesh};
        return {mesh}; // file, unit
    };
    for (const std::string key :
         {"radius", "second_radius", "length", "sides", "half_axes", "file", "unit", "axis", "normal"}) {
        const auto kinds = keys_of(key);
        if (std::find(kinds.begin(), kinds.end(), o.kind) == kinds.end()) table.unused({key}, of);
    }
    const auto needs = [&](bool good, const char* key, const char* unit) {
        if (!good) table.add(key, fmt::format("'{}'{} above 0 is needed for an obstacle {}", key, unit, of));
    };
    const auto positive = [](const Vec3d& v) { return std::min({v.x, v.y, v.z}) > 0; };
    if (o.kind == sphere || o.kind == cylinder || o.kind == capsule) needs(o.radius > 0, "radius", " [m]");
    if (o.kind == box) needs(positive(o.sides), "sides", " [m]");
    if (o.kind == ellipsoid) needs(positive(o.half_axes), "half_axes", " [m]");
    if (o.kind == box && positive(o.sides) && 2 * o.radius > std::min({o.sides.x, o.sides.y, o.sides.z}))
        table.add("radius", fmt::format("edges of {:g} m in radius do not fit the shortest side of {:g} m: at most "
                                        "half of it",
                                        o.radius, std::min({o.sides.x, o.sides.y, o.sides.z})));
    if (o.kind == mesh && o.file.empty())
        table.add("file", "'file' is needed for an obstacle of kind \"mesh\": .stl or .obj");
    if (!o.takes_markers() && !o.is_sharp())
        table.add("surface", fmt::format("an obstacle {} has no markers: use surface = \"sharp\"", of));
    if (zero(o.axis)) table.add("axis", "'axis' has no direction");
    else if (o.normal && (zero(*o.normal) || parallel(*o.normal, o.axis)))
        table.add("normal", "'normal' needs a direction across 'axis'");
    if (o.kind != cylinder) return;
    if (fluid.along_z != FluidBoundary::periodic)
        table.add("kind", "a cylinder goes through the whole box along z, which must be periodic");
    if (o.normal && o.normal->z != 0) table.add("normal", "'normal' of a cylinder along z lies across z");
    if (o.angular_velocity.x != 0 || o.angular_velocity.y != 0)
        table.add("angular_velocity", "a cylinder through the whole box along z turns about z alone");
}

/// Objects to a name that cannot name anything, and to one that an entry before it has.
template <class Spec> void check_entry_name(const std::vector<Spec>& list, std::size_t i, const char* named,
                                            const char* entries, Objections& table) {
    const std::string& name = list[i].name;
    if (!good_name(name))
        table.add("name", fmt::format("'{}' cannot name {}: use letters, digits, _ and -", name, named));
    for (std::size_t j = 0; j < i; ++j)
        if (list[j].name == name) table.add("name", fmt::format("two {} are named '{}'", entries, name));
}

/// As far as the numbers of the fluid allow: they may be wrong themselves.
void check_obstacles(const SceneSpec& scene, Objections& objections) {
    const FluidSpec& fluid = *scene.fluid;
    for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
        const Obstacle& o = scene.obstacles[i];
        TableObjections table(objections, fmt::format("obstacle.{}", i));
        check_entry_name(scene.obstacles, i, "an obstacle", "obstacles", table);
        check_shape(o, fluid, table);
        if ((norm(o.amplitude) > 0) != (o.frequency > 0))
            table.add(o.frequency > 0 ? "frequency" : "amplitude", "'amplitude' [m] and 'frequency' [Hz] go together");
        if (o.is_sharp()) table.unused({"retraction"}, "with surface = \"sharp\"");
        const double least = o.least_axis(), cells = o.is_sharp() ? 1.0 : o.retraction + 0.5;
        const bool solid = o.kind != ObstacleKind::box || o.is_sharp(); // markers of plates may be one sheet
        if (fluid.spacing > 0 && least > 0 && solid && least < cells * fluid.spacing)
            table.add(o.kind == ObstacleKind::box         ? "sides"
                      : o.kind == ObstacleKind::ellipsoid ? "half_axes"
                      : o.kind == ObstacleKind::mesh      ? "unit"
                                                          : "radius",
                      fmt::format("half of its thickness, {:g} m, is too thin for cells of {:g} m: at least {:g} m, or "
                                  "fluid.spacing = {:.3g} at most{}",
                                  least, fluid.spacing, cells * fluid.spacing, least / cells,
                                  o.is_sharp() && o.takes_markers() ? ", or surface = \"markers\"" : ""));
    }
}

/// Rods that feel the fluid.
void check_two_way(const SceneSpec& scene, Objections& objections) {
    const auto one_way = [](const std::string& what) {
        return what + "; coupling = \"one_way\" has rods move as if there were no fluid";
    };
    if (scene.fluid->scheme == FlowScheme::crank_nicolson)
        objections.add("fluid.scheme", one_way("rods that feel the fluid need a scheme of explicit viscosity"));
    if (kicks_backwards(scene.time.integrator))
        objections.add("time.integrator",
                       one_way("rods that feel the fluid need the integrator \"verlet\", whose kicks all go forward"));
}

/// Springs and dampers, or none.
void check_forcing(const SceneSpec& scene, Objections& table) {
    const ImmersionSpec& immersion = scene.immersion;
    if (immersion.forcing == ForcingKind::direct)
        return table.unused({"penalty_stiffness", "penalty_damping"}, "without forcing = \"penalty\"");
    table.unused({"sweeps", "slip"}, "with forcing = \"penalty\"");
    if (immersion.penalty_stiffness == 0 && immersion.penalty_damping == 0)
        table.add("forcing", "forcing = \"penalty\" needs 'penalty_stiffness' [N/m^3] or 'penalty_damping' [N s/m^3]");
    if (scene.rods.empty()) table.add("forcing", "forcing = \"penalty\" is for rods in a fluid, and there are none");
    if (scene.fluid->scheme == FlowScheme::crank_nicolson)
        table.add("forcing", "forcing = \"penalty\" needs a scheme of explicit viscosity");
}

void check_rods(const SceneSpec& scene, Objections& objections) {
    if (scene.rods.empty()) return;
    if (scene.immersion.coupling == RodCoupling::two_way) check_two_way(scene, objections);
    if (scene.time.relax) objections.add("time.relax", "'relax' has no motion for the fluid to follow");
    if (!scene.start.from.empty())
        objections.add("start.from", "rods in a fluid cannot begin with the state of another run yet");
}

/// A box that moves with rods.
void check_motion(const SceneSpec& scene, TableObjections& table) {
    const FluidSpec& fluid = *scene.fluid;
    if (!fluid.follows_rods) return;
    const std::string key = "follows_rods";
    if (scene.rods.empty() || scene.immersion.coupling == RodCoupling::one_way)
        table.add(key, "a box of fluid follows rods that feel it, and there are none");
    if (fluid.along_x != FluidBoundary::free_slip && fluid.along_x != FluidBoundary::no_slip)
        table.add(key, "a box that moves along x needs along_x = \"free_slip\" or \"no_slip\"");
    if (!scene.obstacles.empty()) table.add(key, "obstacles stand in a box that stays where it is");
    if (keeps_rates(fluid.scheme))
        table.add(key, "a box that moves needs a scheme without rates of the last step: \"rk3\"");
    for (std::size_t i = 0; i < scene.fluid_outputs.size(); ++i)
        if (scene.fluid_outputs[i].kind == FluidOutputKind::slice && scene.fluid_outputs[i].across == Direction::x)
            table.add(key, fmt::format("the output '{}' is of a slice across x, which would move with the box",
                                       scene.fluid_outputs[i].name));
    for (const FluidProbeSpec& probe : scene.fluid_probes)
        table.add(key, fmt::format("the fluid's probe '{}' stays where it is, and the box would leave it: use a "
                                   "[[fluid_output]]",
                                   probe.name));
}

void check_names(const FluidOutputSpec& spec, Objections& table) {
    std::vector<std::string_view> known;
    for (const CellFieldEntry& field : cell_field_table) known.push_back(field.name);
    for (std::size_t i = 0; i < spec.which.size(); ++i) {
        const std::string& name = spec.which[i];
        const auto before = spec.which.begin() + static_cast<long>(i);
        if (std::find(known.begin(), known.end(), name) == known.end())
            table.add(fmt::format("fields.{}", i),
                      fmt::format("a fluid has no field '{}'{}", name, suggestion(name, known, "the choices are")));
        else if (std::find(spec.which.begin(), before, name) != before)
            table.add(fmt::format("fields.{}", i), fmt::format("'{}' is named twice", name));
    }
}

void check_slice(const FluidOutputSpec& spec, const FluidGrid& grid, Objections& table) {
    if (!table.given("at")) return table.add("at", "'at' [m] is needed for a slice");
    const auto d = static_cast<std::size_t>(spec.across);
    const double lower = component_of(grid.lower, static_cast<int>(d)), upper = lower + grid.h * grid.cells[d];
    if (spec.at < lower || spec.at > upper)
        table.add("at",
                  fmt::format("a slice across {} at {:g} m is outside of the fluid, which reaches from {:g} to {:g} m",
                              direction_names[d], spec.at, lower, upper));
}

void check_box(const FluidOutputSpec& spec, const FluidGrid& grid, Objections& table) {
    const double within = 0.5 * grid.h;
    const Vec3d upper = grid.upper();
    for (const auto& [key, corner] : {std::pair{"lower", spec.lower}, std::pair{"upper", spec.upper}}) {
        if (!corner) continue;
        const Vec3d below = *corner - grid.lower, above = upper - *corner;
        if (std::min({below.x, below.y, below.z, above.x, above.y, above.z}) < -within)
            return table.add(
                key, fmt::format("this corner is outside of the fluid, which reaches from [{:g}, {:g}, {:g}] to [{:g}, "
                                 "{:g}, {:g}] m",
                                 grid.lower.x, grid.lower.y, grid.lower.z, upper.x, upper.y, upper.z));
    }
    FluidOutputSpec whole = spec;
    whole.average = 1;
    const CellBox box = cells_of(whole, grid);
    for (std::size_t d = 0; d < 3; ++d) {
        const std::string along(direction_names[d]);
        if (box.count[d] < 1)
            return table.add(spec.upper ? "upper" : "lower", fmt::format("the box has no cells along {}", along));
        if (const long rest = box.count[d] % spec.average; rest > 0)
            table.add(
                "average",
                fmt::format(
                    "cubes of {} cells do not fill the box, which has {} cells along {}: the last {} would be left out",
                    spec.average, box.count[d], along, rest));
    }
}

/// As far as the numbers of the fluid allow: they may be wrong themselves.
void check_outputs(const SceneSpec& scene, bool good_grid, Objections& objections) {
    for (std::size_t i = 0; i < scene.fluid_outputs.size(); ++i) {
        const FluidOutputSpec& spec = scene.fluid_outputs[i];
        TableObjections table(objections, fmt::format("fluid_output.{}", i));
        check_entry_name(scene.fluid_outputs, i, "files", "outputs of the fluid", table);
        if (spec.every > scene.time.duration)
            table.add("every", fmt::format("'every' {} s never comes due within 'duration' of {} s", spec.every,
                                           scene.time.duration));
        check_names(spec, table);
        const std::string where = fmt::format("for an output of kind \"{}\"", nth(fluid_output_names, spec.kind));
        if (spec.kind != FluidOutputKind::slice) table.unused({"across", "at"}, where);
        if (spec.kind != FluidOutputKind::box) table.unused({"lower", "upper", "average"}, where);
        if (spec.kind != FluidOutputKind::blocks) table.unused({"criterion", "threshold", "edge"}, where);
        else if (!table.given("threshold"))
            table.add("threshold", "'threshold' [1/s^2 of q, 1/s of vorticity] is needed for blocks");
        if (!good_grid) continue;
        const FluidGrid grid = scene.fluid->constants().grid;
        if (spec.kind == FluidOutputKind::slice) check_slice(spec, grid, table);
        if (spec.kind == FluidOutputKind::box) check_box(spec, grid, table);
    }
}

/// Objects to columns of a time series that the scene does not have.
void stop_without_series(const SceneSpec& scene, const char* key, const char* columns, Objections& objections) {
    if (!(scene.output.series > 0))
        objections.add(key, fmt::format("{} are columns of the time series: set output.series [s]", columns));
}

void check_probes(const SceneSpec& scene, bool good_grid, Objections& objections) {
    for (std::size_t i = 0; i < scene.fluid_probes.size(); ++i) {
        const FluidProbeSpec& probe = scene.fluid_probes[i];
        TableObjections table(objections, fmt::format("fluid_probe.{}", i));
        check_entry_name(scene.fluid_probes, i, "columns", "probes of the fluid", table);
        if (!good_grid) continue;
        const FluidGrid grid = scene.fluid->constants().grid;
        const Vec3d upper = grid.upper();
        if (!grid.holds(probe.at))
            table.add("at", fmt::format("this place is outside of the fluid, which reaches from [{:g}, {:g}, {:g}] to "
                                        "[{:g}, {:g}, {:g}] m",
                                        grid.lower.x, grid.lower.y, grid.lower.z, upper.x, upper.y, upper.z));
    }
    if (!scene.fluid_probes.empty()) stop_without_series(scene, "fluid_probe.0", "probes", objections);
}

/// Checks the columns of power.
void check_fluid_power(const SceneSpec& scene, Objections& objections) {
    if (!FluidTables::has_immersed(scene))
        return TableObjections(objections, "output")
            .unused({"fluid_power"}, "without rods, bodies or obstacles in a [fluid]");
    if (scene.output.fluid_power) stop_without_series(scene, "output.fluid_power", "powers", objections);
}

/// Checks the groups whose rods have columns of their own.
void check_fluid_forces(const SceneSpec& scene, Objections& objections) {
    const std::vector<std::string>& names = scene.output.fluid_forces;
    if (!scene.fluid || scene.rods.empty())
        return TableObjections(objections, "output").unused({"fluid_forces"}, "without rods or bodies in a [fluid]");
    if (!names.empty())
        stop_without_series(scene, "output.fluid_forces", "forces on single rods and bodies", objections);
    for (std::size_t i = 0; i < names.size(); ++i) {
        const std::string key = fmt::format("output.fluid_forces.{}", i);
        group_named(scene, names[i], objections, key);
        if (std::find(names.begin(), names.begin() + static_cast<long>(i), names[i]) !=
            names.begin() + static_cast<long>(i))
            objections.add(key, fmt::format("the group '{}' is named twice", names[i]));
    }
}

/// Checks the margins that stand in place of a box.
void check_margins(const SceneSpec& scene, Objections& table) {
    const std::string key = scene.fluid->margin_lower ? "margin_lower" : "margin_upper";
    if (const std::string fault = unfitted(scene); !fault.empty()) table.add(key, fault);
    table.unused({"cells", "lower"}, "beside margins, which say the box");
}

/// Objects to keys of bodies in a fluid that nothing uses.
void check_immersion(const SceneSpec& scene, Objections& table) {
    if (!FluidTables::has_immersed(scene))
        table.unused({"delta", "forcing", "sweeps", "slip"}, "without [[obstacle]] or rods in a [fluid]");
    const auto sharp = [](const Obstacle& o) { return o.is_sharp(); };
    if (scene.fluid && scene.rods.empty() && !scene.obstacles.empty() &&
        std::all_of(scene.obstacles.begin(), scene.obstacles.end(), sharp)) {
        table.unused({"delta"}, "with sharp surfaces alone");
        if (scene.fluid->scheme != FlowScheme::crank_nicolson)
            table.unused({"sweeps", "slip"}, "with sharp surfaces alone and an explicit scheme");
    }
    if (!scene.fluid || scene.rods.empty())
        table.unused({"retraction", "coupling", "inner_inertia"}, "without rods in a [fluid]");
    if (scene.immersion.coupling == RodCoupling::one_way)
        table.unused({"inner_inertia"}, "with coupling = \"one_way\"");
    if (std::none_of(scene.rods.begin(), scene.rods.end(), [](const RodSpec& rods) { return rods.body.has_value(); }))
        table.unused({"body_surface"}, "without [[bodies]] in a [fluid]");
    if (std::all_of(scene.rods.begin(), scene.rods.end(), [](const RodSpec& rods) { return rods.body.has_value(); }))
        table.unused({"rod_surface"}, "without [[rods]] in a [fluid]");
}

/// Objects to each table of a list that nothing uses.
void check_unused(const char* name, const auto& list, const char* without, Objections& objections) {
    for (std::size_t i = 0; i < list.size(); ++i)
        objections.add(fmt::format("{}.{}", name, i), fmt::format("[[{}]] has no use without {}", name, without));
}

/// Checks the faces that the fluid flows through.
void check_inflow(const FluidSpec& fluid, Objections& table) {
    for (const auto& [key, bound] : {std::pair{"along_y", fluid.along_y}, std::pair{"along_z", fluid.along_z}})
        if (bound == FluidBoundary::through)
            table.add(key, fmt::format("'{}': the fluid flows through along x alone", key));
    if (fluid.along_x != FluidBoundary::through)
        table.unused({"inflow", "inflow_profile"}, "without along_x = \"through\"");
    else if (!(fluid.inflow.x > 0))
        table.add("inflow", "'inflow' [m/s] towards positive x is needed where the fluid flows through");
    else if (fluid.inflow_profile == InflowProfile::parabolic && fluid.along_y != FluidBoundary::no_slip &&
             fluid.along_z != FluidBoundary::no_slip)
        table.add("inflow_profile", "a parabolic inflow needs \"no_slip\" walls across y or z");
}

/// Checks implicit viscosity.
void check_scheme(const FluidSpec& fluid, Objections& table) {
    if (fluid.scheme != FlowScheme::crank_nicolson) return;
    if (fluid.along_x == FluidBoundary::through)
        table.add("scheme",
                  "'crank_nicolson' solves for viscosity between walls and periods, not where the fluid flows through: "
                  "use another scheme or another 'along_x'");
    if (fluid.pressure == PressureMethod::multigrid)
        table.add("scheme",
                  "'crank_nicolson' solves for viscosity by transforms alone: it needs pressure = \"direct\"");
}

/// Objects to keys and tables that a scene without rods does not use.
void check_without_rods(const SceneSpec& scene, Objections& objections) {
    TableObjections(objections, "output").unused({"trajectory", "tips", "audit", "observables"}, "without rods");
    TableObjections(objections, "time")
        .unused({"safety", "e_min", "integrator", "damping", "rest_speed", "relax", "relax_tolerance", "force_dt"},
                "without rods");
    check_unused("load", scene.loads, "rods", objections);
    check_unused("damping", scene.damping, "rods", objections);
    check_unused("wall", scene.walls, "rods", objections);
    check_unused("joint", scene.joints, "rods", objections);
    check_unused("assembly", scene.assemblies, "rods", objections);
    if (scene.contact) objections.add("contact", "[contact] has no use without rods");
    if (!scene.start.from.empty()) objections.add("start.from", "a scene of a fluid begins with its own start");
}

} // namespace

void FluidTables::check(const SceneSpec& given, Objections& objections) {
    TableObjections table(objections, "fluid"), immersion(objections, "immersion");
    SceneSpec fitted;
    if (given.fluid && given.fluid->fitted()) {
        check_margins(given, table);
        fitted = given;
        fitted.fluid = fitted_fluid(given);
    }
    const SceneSpec& scene = fitted.fluid ? fitted : given;
    if (scene.output.fluid_fields > 0 && !scene.fluid)
        objections.add("output.fields", "'fields' has no use without [fluid]");
    check_fluid_forces(scene, objections);
    check_fluid_power(scene, objections);
    check_immersion(scene, immersion);
    if (!scene.fluid) {
        check_unused("obstacle", scene.obstacles, "[fluid]", objections);
        check_unused("fluid_output", scene.fluid_outputs, "[fluid]", objections);
        check_unused("fluid_probe", scene.fluid_probes, "[fluid]", objections);
        return;
    }
    const FluidSpec& fluid = *scene.fluid;
    check_rods(scene, objections);
    check_forcing(scene, immersion);
    check_cells(fluid, table);
    check_inflow(fluid, table);
    if (fluid.pressure != PressureMethod::multigrid)
        table.unused({"pressure_tolerance"}, "without pressure = \"multigrid\"");
    else table.unused({"pressure_exchange"}, "with pressure = \"multigrid\"");
    check_ranks(fluid, table);
    check_walls(fluid, table);
    check_motion(scene, table);
    check_scheme(fluid, table);
    check_obstacles(scene, objections);
    const auto& cells = fluid.cells;
    const bool good_grid = cells.size() == 3 && *std::min_element(cells.begin(), cells.end()) > 0 && fluid.spacing > 0;
    check_outputs(scene, good_grid, objections);
    check_probes(scene, good_grid, objections);
    if (!fluid.velocity_formula.empty()) {
        const StartVelocity start(fluid.velocity_formula, names_for_formulas(scene));
        add_faults("velocity_formula", start.faults(), table);
    }
    if (scene.rods.empty()) check_without_rods(scene, objections);
}

} // namespace skein
