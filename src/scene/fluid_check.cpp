#include "scene/fluid_check.hpp"

#include "fluid/start_velocity.hpp"
#include "scene/group_names.hpp"
#include "scene/scene_tables.hpp"
#include "scene/table_objections.hpp"

#include <cmath>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr long most_cells = 16384; ///< along a direction
constexpr long least_between_walls = 4;

bool is_smooth(long n) {
    for (const long factor : {2, 3, 5, 7})
        while (n % factor == 0) n /= factor;
    return n == 1;
}
long next_smooth(long n) {
    while (!is_smooth(n)) ++n;
    return n;
}

void check_cells(const FluidSpec& fluid, Objections& table) {
    const FluidBoundary bounds[] = {fluid.along_x, fluid.along_y, fluid.along_z};
    table.length("cells", fluid.cells.size(), 3, "along x, y and z");
    for (std::size_t d = 0; d < std::min<std::size_t>(3, fluid.cells.size()); ++d) {
        const long n = fluid.cells[d];
        const std::string key = fmt::format("cells.{}", d);
        if (n < 1 || n > most_cells)
            table.add(key, fmt::format("{} cells along {}: from 1 to {} are possible", n, "xyz"[d], most_cells));
        else if (!is_smooth(n) && fluid.pressure == PressureMethod::direct)
            table.add(key,
                      fmt::format("{} cells along {} are no product of 2, 3, 5 and 7; {} would do, or pressure = \"multigrid\"", n,
                                  "xyz"[d], next_smooth(n)));
        else if (bounds[d] != FluidBoundary::periodic && n < least_between_walls)
            table.add(key, fmt::format("{} cells along {}, which is not periodic, are too few: at least {}", n, "xyz"[d],
                                       least_between_walls));
    }
}

/// As far as the numbers of the fluid allow: they may be wrong themselves.
void check_obstacles(const SceneSpec& scene, Objections& objections) {
    const FluidSpec& fluid = *scene.fluid;
    for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
        const Obstacle& o = scene.obstacles[i];
        TableObjections table(objections, fmt::format("obstacle.{}", i));
        if (!good_name(o.name))
            table.add("name", fmt::format("'{}' cannot name an obstacle: use letters, digits, _ and -", o.name));
        for (std::size_t j = 0; j < i; ++j)
            if (scene.obstacles[j].name == o.name) table.add("name", fmt::format("two obstacles are named '{}'", o.name));
        if (o.kind == ObstacleKind::sphere) table.unused({"second_radius"}, "of a sphere");
        else if (fluid.along_z != FluidBoundary::periodic)
            table.add("kind", "a cylinder goes through the whole box along z, which must be periodic");
        if ((norm(o.amplitude) > 0) != (o.frequency > 0))
            table.add(o.frequency > 0 ? "frequency" : "amplitude", "'amplitude' [m] and 'frequency' [Hz] go together");
        const double least =
            o.kind == ObstacleKind::cylinder && o.second_radius > 0 ? std::min(o.radius, o.second_radius) : o.radius;
        if (fluid.spacing > 0 && least < (o.retraction + 0.5) * fluid.spacing)
            table.add("radius", fmt::format("a half axis of {:g} m is too thin for cells of {:g} m: at least {:g} m", least,
                                            fluid.spacing, (o.retraction + 0.5) * fluid.spacing));
    }
}

} // namespace

void check_fluid(const SceneSpec& scene, Objections& objections) {
    if (scene.output.fluid_fields > 0 && !scene.fluid) objections.add("output.fields", "'fields' has no use without [fluid]");
    if (scene.obstacles.empty())
        TableObjections(objections, "immersion").unused({"delta", "sweeps", "slip"}, "without [[obstacle]]");
    if (!scene.fluid) {
        for (std::size_t i = 0; i < scene.obstacles.size(); ++i)
            objections.add(fmt::format("obstacle.{}", i), "[[obstacle]] has no use without [fluid]");
        return;
    }
    const FluidSpec& fluid = *scene.fluid;
    TableObjections table(objections, "fluid");
    if (!scene.rods.empty()) table.add("", "rods and a fluid do not feel each other yet: a scene has one of both");
    check_cells(fluid, table);
    for (const auto& [key, bound] : {std::pair{"along_y", fluid.along_y}, std::pair{"along_z", fluid.along_z}})
        if (bound == FluidBoundary::through) table.add(key, fmt::format("'{}': the fluid flows through along x alone", key));
    if (fluid.along_x != FluidBoundary::through) table.unused({"inflow"}, "without along_x = \"through\"");
    else if (!(fluid.inflow.x > 0))
        table.add("inflow", "'inflow' [m/s] towards positive x is needed where the fluid flows through");
    if (fluid.pressure != PressureMethod::multigrid) table.unused({"pressure_tolerance"}, "without pressure = \"multigrid\"");
    check_obstacles(scene, objections);
    if (!fluid.velocity_formula.empty()) {
        const StartVelocity start(fluid.velocity_formula, names_for_formulas(scene));
        for (const FormulaFault& fault : start.faults()) {
            const std::string message = fmt::format("'velocity_formula': {}", fault.message);
            if (fault.part.formula < 0) table.add("velocity_formula", message);
            else
                table.add_within(fmt::format("velocity_formula.{}", fault.part.formula), fault.part.begin, fault.part.length,
                                 message);
        }
    }
    if (!scene.rods.empty()) return;
    TableObjections(objections, "output").unused({"trajectory", "tips", "audit", "observables"}, "without rods");
    TableObjections(objections, "time")
        .unused({"safety", "e_min", "integrator", "damping", "rest_speed", "relax", "relax_tolerance", "force_dt"}, "without rods");
    const auto no_use = [&](const char* name, const auto& list) {
        for (std::size_t i = 0; i < list.size(); ++i)
            objections.add(fmt::format("{}.{}", name, i), fmt::format("[[{}]] has no use without rods", name));
    };
    no_use("load", scene.loads), no_use("damping", scene.damping), no_use("wall", scene.walls), no_use("joint", scene.joints),
        no_use("assembly", scene.assemblies);
    if (scene.contact) objections.add("contact", "[contact] has no use without rods");
    if (!scene.start.from.empty()) objections.add("start.from", "a scene of a fluid begins with its own start");
}

} // namespace skein
