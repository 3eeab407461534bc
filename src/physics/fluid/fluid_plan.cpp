#include "physics/fluid/fluid_plan.hpp"

#include "fluid/slab_coupling.hpp"
#include "fluid/start_velocity.hpp"
#include "immersion/body_surface.hpp"
#include "immersion/plate_markers.hpp"
#include "io/mesh_file.hpp"
#include "physics/fluid/fitted_fluid.hpp"
#include "physics/fluid/fluid_pressure.hpp"
#include "physics/fluid/stated_speeds.hpp"
#include "physics/plan_input.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

namespace skein {

namespace {

/// Number of solutions for three components of velocity and the pressure in an implicit step.
double implicit_solves(const FluidPlan& plan) { return 1.0 + (plan.has_bodies() ? plan.forcing.sweeps : 0); }
double projections(FlowScheme scheme) { return scheme == FlowScheme::rk3_projected ? 3 : 1; }

/// The largest sum of components at the start, at up to `most` places along each direction.
double fluid_speed_at_start(const FluidPlan& plan) {
    constexpr int most = 64;
    const FluidGrid& grid = plan.constants.grid;
    const StartVelocity velocity(plan.velocity_formula, plan.names);
    std::array<int, 3> places{};
    for (std::size_t d = 0; d < 3; ++d) places[d] = std::min(most, grid.cells[d]);
    const auto spacing = [&](std::size_t d) { return grid.h * grid.cells[d] / places[d]; };
    std::vector<double> row(static_cast<std::size_t>(places[0]));
    double speed = 0;
    for (int k = 0; k < places[2]; ++k)
        for (int j = 0; j < places[1]; ++j) {
            const Vec3d first = grid.lower + Vec3d{0.5 * spacing(0), (j + 0.5) * spacing(1), (k + 0.5) * spacing(2)};
            std::vector<double> sum(row.size(), 0);
            for (int c = 0; c < 3; ++c) {
                velocity(c, first, spacing(0), row);
                for (std::size_t i = 0; i < row.size(); ++i) sum[i] += std::abs(row[i]);
            }
            speed = std::max(speed, *std::max_element(sum.begin(), sum.end()));
        }
    return speed;
}

/// An expected speed stands for all that is estimated, not for what the scene states of the start itself.
FluidSpeed speed_of(const FluidPlan& plan, double expected, std::span<const StatedSpeed> of_rods) {
    FluidSpeed speed;
    const auto take = [&](double value, const std::string& by) {
        if (value > speed.value) speed = {value, by};
    };
    take(expected, "fluid.expected_speed");
    for (const StatedSpeed& stated : of_rods)
        if (stated.at_once || expected == 0) take(stated.value, stated.by);
    if (expected > 0) return speed;
    take(largest_inflow_share(plan.constants) * sum_of(plan.constants.inflow), "the inflow");
    take(wall_speed(plan.constants), "a moving wall");
    if (plan.constants.frequency > 0)
        take(sum_of(plan.constants.acceleration) / (2 * std::numbers::pi * plan.constants.frequency),
             "the acceleration");
    if (!plan.velocity_formula.empty()) take(fluid_speed_at_start(plan), "the velocity at the start");
    for (const Obstacle& o : plan.obstacles)
        take(sum_of(o.velocity) + 2 * std::numbers::pi * o.frequency * sum_of(o.amplitude) + o.turning_speed(),
             "an obstacle");
    return speed;
}

std::vector<CellField> fields_of(const std::vector<std::string>& names) {
    std::vector<CellField> fields;
    for (std::size_t f = 0; f < std::size(cell_field_table); ++f)
        if (names.empty() || std::find(names.begin(), names.end(), cell_field_table[f].name) != names.end())
            fields.push_back(static_cast<CellField>(f));
    return fields;
}

std::vector<FluidOutput> outputs_of(const SceneSpec& scene, const FluidGrid& grid) {
    std::vector<FluidOutput> outputs;
    if (scene.output.fluid_fields > 0)
        outputs.push_back(
            {.interval = scene.output.fluid_fields, .fields = fields_of({}), .box = {{0, 0, 0}, grid.cells, 1}});
    for (const FluidOutputSpec& spec : scene.fluid_outputs)
        outputs.push_back({.name = spec.name,
                           .kind = spec.kind,
                           .interval = spec.every,
                           .fields = fields_of(spec.which),
                           .precision = spec.precision,
                           .across = spec.across,
                           .box = cells_of(spec, grid),
                           .edge = static_cast<int>(spec.edge),
                           .criterion = spec.criterion == BlockCriterion::q ? CellField::q : CellField::vorticity,
                           .threshold = spec.threshold});
    return outputs;
}

/// Area of an ellipsoid with these half axes, over the square of the spacing; of a tube where they have no bound.
double area_within(Vec3d half, const FluidGrid& grid) {
    for (int d = 0; d < 3; ++d) {
        double& along = d == 0 ? half.x : d == 1 ? half.y : half.z;
        along = std::min(along / grid.h, 0.5 * nth(grid.cells, d));
    }
    constexpr double p = 1.6; // Thomsen's formula, within 1.2 %
    const double x = std::pow(half.x, p), y = std::pow(half.y, p), z = std::pow(half.z, p);
    return 4 * std::numbers::pi * std::pow((x * y + y * z + z * x) / 3, 1 / p);
}

/// Area of a spheroid as long as a body and of its volume, over the square of the spacing.
double area_of(const BodyShape& body, const FluidGrid& grid) {
    const double across = std::sqrt(displaced_volume(body).volume / (4.0 / 3 * std::numbers::pi * body.reach));
    return area_within({body.reach, across, across}, grid);
}

/// Area of the sharp part of a rod, over the square of the spacing.
double sharp_area(const RodGroup& group, std::span<const double> shares, const FluidGrid& grid) {
    const bool plate = spans_box(group, grid);
    double area = 0;
    for (std::size_t k = 0; k < group.element.size(); ++k) {
        const auto [a, b] = half_axes(group, k);
        const double around = plate ? 4 * b : 2 * std::numbers::pi * std::sqrt(0.5 * (a * a + b * b));
        area += share_at(shares, k, 0.5) * around * group.element[k].rest_length;
    }
    return area / (grid.h * grid.h);
}

} // namespace

double FluidPlan::bytes_per_cell(int ranks) const {
    if (constants.pressure != PressureMethod::direct) return 80 + multigrid_bytes_per_cell;
    const bool responds = constants.scheme == FlowScheme::crank_nicolson && has_bodies();
    const bool keeps_gain = constants.scheme == FlowScheme::crank_nicolson && writes_pressure(*this);
    return 96 + (responds ? 8 : 0) + (keeps_gain ? 8 : 0) + (across(ranks) > 1 ? 16 : 0);
}

double FluidPlan::solve_bytes(int ranks) const {
    if (constants.pressure != PressureMethod::direct || ranks == 1) return 0;
    const FluidGrid& grid = constants.grid;
    const double shares = across(ranks), slabs = ranks / shares, own = static_cast<double>(grid.count()) / ranks;
    const auto there_and_back = [](double numbers, double among) {
        return 2 * sizeof(double) * numbers * (among - 1) / among;
    };
    const double rows = there_and_back(own, shares);
    if (constants.exchange == ColumnExchange::transposes) return rows + there_and_back(own, slabs);
    const double neighbours = slabs == 1                      ? 0
                              : grid.periodic(2) || slabs > 2 ? 2
                                                              : 1,
                 columns = 1.0 * grid.cells[0] * grid.cells[1];
    const auto coupling = static_cast<double>(coupling_coefficients(grid, static_cast<int>(slabs)));
    return rows + neighbours * sizeof(double) * columns / shares + 2 * there_and_back(coupling / shares, slabs);
}

double FluidPlan::column_bytes(int ranks) const {
    const bool implicit = constants.scheme == FlowScheme::crank_nicolson;
    return (implicit ? 4 * implicit_solves(*this) : projections(constants.scheme)) * solve_bytes(ranks);
}

double FluidPlan::ns_per_cell_step() const {
    constexpr double with_one_projection = 45, multigrid = 1000; // to the default tolerance
    constexpr double implicit_stage = 10, implicit_solve = 57;
    if (constants.scheme == FlowScheme::crank_nicolson) return implicit_stage + implicit_solve * implicit_solves(*this);
    return with_one_projection +
           (constants.pressure == PressureMethod::direct ? 0 : multigrid * projections(constants.scheme));
}

double FluidPlan::surface_ns() const {
    // Measured by cell of the surface, which is put to its place once in a stage, and twice if the fluid moves it.
    constexpr double of_bodies = 3000, of_rods = 25000;
    double all = 0;
    for (const Obstacle& o : obstacles)
        if (o.is_sharp() && o.moves()) all += of_bodies * area_within(o.shape()->extent(), constants.grid);
    for (const RodsInFluid& r : rods) all += (two_way() ? 2 : 1) * (r.body ? of_bodies : of_rods) * r.sharp_area;
    return stage_parts(constants.scheme).count * all;
}

double FluidPlan::ghost_bytes(int ranks) const {
    if (ranks == 1) return 0;
    const auto [nx, ny, nz] = constants.grid.cells;
    const double shares = across(ranks), slabs = ranks / shares, of_row = 2 * FieldLayout::ghosts * sizeof(double) * nx;
    const bool implicit = constants.scheme == FlowScheme::crank_nicolson;
    const double solves = implicit ? implicit_solves(*this) : projections(constants.scheme),
                 fields = implicit ? 4 + 5 * solves : 3 * stage_parts(constants.scheme).count + 2 * solves;
    return of_row * ((slabs > 1 ? fields * ny / shares : 0) + (shares > 1 ? (fields + solves) * nz / slabs : 0));
}

double FluidPlan::steps(std::int64_t run_steps, double dt) const {
    if (every > 0) return static_cast<double>(run_steps) / static_cast<double>(every);
    return std::max(1.0, std::ceil(dt / step_limit() * (1 - 1e-12))) * static_cast<double>(run_steps);
}

double FluidOutput::bytes_per_cell() const {
    int numbers = 0;
    for (const CellField field : fields) numbers += entry_of(field).components;
    return numbers * (precision == Precision::single ? 4.0 : 8.0);
}

double FluidOutput::frame_bytes() const {
    const double cells =
        kind == FluidOutputKind::blocks ? std::pow(edge, 3) : 1.0 * box.count[0] * box.count[1] * box.count[2];
    return bytes_per_cell() * cells;
}

double FluidOutput::most_blocks(const FluidGrid& grid) const {
    double blocks = 1;
    for (const int cells : grid.cells) blocks *= std::ceil(static_cast<double>(cells) / edge);
    return blocks;
}

double FluidOutput::most_bytes(const FluidGrid& grid) const {
    return frame_bytes() * (kind == FluidOutputKind::blocks ? most_blocks(grid) : 1);
}

CellBox cells_of(const FluidOutputSpec& spec, const FluidGrid& grid) {
    CellBox box{{0, 0, 0}, grid.cells, 1};
    if (spec.kind == FluidOutputKind::slice) {
        const auto d = static_cast<std::size_t>(spec.across);
        const double cell = std::floor((spec.at - component_of(grid.lower, static_cast<int>(d))) / grid.h);
        box.first[d] = static_cast<int>(std::clamp(cell, 0.0, grid.cells[d] - 1.0));
        box.count[d] = 1;
    }
    if (spec.kind == FluidOutputKind::box) {
        box.average = static_cast<int>(spec.average);
        for (std::size_t d = 0; d < 3; ++d) {
            const auto corner = [&](const std::optional<Vec3d>& of, int absent) {
                if (!of) return absent;
                const double cell = std::round(
                    (component_of(*of, static_cast<int>(d)) - component_of(grid.lower, static_cast<int>(d))) / grid.h);
                return static_cast<int>(std::clamp(cell, 0.0, 1.0 * grid.cells[d]));
            };
            box.first[d] = corner(spec.lower, 0);
            box.count[d] = (corner(spec.upper, grid.cells[d]) - box.first[d]) / box.average;
        }
    }
    return box;
}

namespace {

/// Half axes of a group's sections, and how markers lie on them.
void add_sections(const RodGroup& group, const ImmersedKinds::Kind& in_fluid, const FluidPlan& fluid,
                  RodsInFluid& rods) {
    const double h = fluid.constants.grid.h, retraction = fluid.retraction * h;
    const bool spans = spans_box(group, fluid.constants.grid);
    double thickest = 0;
    for (std::size_t k = 0; k < group.element.size(); ++k) {
        const HalfAxes axes = half_axes(group, k);
        const double across = spans ? axes.along_d1 : axes.along_d2; // a plate is as thick as it is along d1
        rods.least_axis = std::min({rods.least_axis, axes.along_d1 / h, across / h});
        rods.most_axis = std::max({rods.most_axis, axes.along_d1 / h, across / h});
        thickest = std::max(thickest, std::min(axes.along_d1, across) / h);
        if (in_fluid.sharp && in_fluid.sharp_shares[k] == 1 && in_fluid.sharp_shares[k + 1] == 1) continue;
        const SectionMarkers kind =
            spans ? plate_markers(axes.along_d1, h, retraction) : section_markers(axes, h, retraction);
        nth(rods.has, kind) = true;
    }
    rods.thickest = std::min(rods.thickest, thickest);
}

/// Share of a rod's length that acts by a sharp surface; of a body, 0 or 1.
double sharp_part(const RodGroup& group, const ImmersedKinds::Kind& in_fluid) {
    if (!in_fluid.sharp || group.body()) return in_fluid.sharp ? 1 : 0;
    double sharp = 0, length = 0;
    for (std::size_t k = 0; k < group.element.size(); ++k) {
        length += group.element[k].rest_length;
        sharp += share_at(in_fluid.sharp_shares, k, 0.5) * group.element[k].rest_length;
    }
    return sharp / length;
}

/// Half thicknesses of a body's parts.
void add_parts(const BodyShape& body, double spacing, RodsInFluid& rods) {
    for (const BodyShape::Part& part : body.part) {
        const auto [least, most] = std::minmax({part.half.x, part.half.y, part.half.z});
        rods.least_axis = std::min(rods.least_axis, (part.radius + least) / spacing);
        rods.most_axis = std::max(rods.most_axis, (part.radius + most) / spacing);
    }
}

RodsInFluid rods_in_fluid(const RodGroup& group, const FluidPlan& fluid) {
    RodsInFluid rods{.name = group.name(),
                     .body = group.body() != nullptr,
                     .asks_sharp = fluid.kinds->asks_sharp(group),
                     .least_axis = HUGE_VAL,
                     .density_ratio = group.spec().material.density / fluid.constants.density};
    if (const BodyShape* body = group.body()) {
        add_parts(*body, fluid.constants.grid.h, rods);
        rods.density_ratio = body->mass / (displaced_volume(*body).volume * fluid.constants.density);
    }
    rods.feels_fluid = fluid.coupling == RodCoupling::two_way;
    double markers = 0, all = 0;
    for_each_kind(group, [&](const RodGroup& kind, double count) {
        const ImmersedKinds::Kind& in_fluid = fluid.kinds->of(kind, 0);
        if (!group.body()) add_sections(kind, in_fluid, fluid, rods);
        markers += count * static_cast<double>(in_fluid.markers.size());
        rods.sharp += count * sharp_part(kind, in_fluid);
        if (in_fluid.sharp)
            rods.sharp_area += count * (group.body() ? area_of(*group.body(), fluid.constants.grid)
                                                     : sharp_area(kind, in_fluid.sharp_shares, fluid.constants.grid));
        all += count;
        if (rods.feels_fluid) rods.least_inertia = std::min(rods.least_inertia, in_fluid.inertia->least_effective());
    });
    rods.markers = std::lround(markers / all);
    rods.sharp = markers > 0 ? rods.sharp / all : 1; // without rounding
    return rods;
}

/// Throws InputError for an obstacle at rest that no cell can meet.
void stop_outside(const Obstacle& o, const FluidGrid& grid) {
    if (o.moves()) return;
    const Vec3d extent = o.shape()->extent();
    const double reach = std::max({extent.x, extent.y, std::isfinite(extent.z) ? extent.z : 0});
    const Vec3d upper = grid.upper();
    for (int d = 0; d < 3; ++d) {
        const double at = component_of(o.centre, d);
        if (grid.periodic(d) || (at + reach > component_of(grid.lower, d) && at - reach < component_of(upper, d)))
            continue;
        throw InputError(fmt::format(
            "{}: obstacle '{}' at [{:g}, {:g}, {:g}] m lies outside of the fluid, which reaches from [{:g}, "
            "{:g}, {:g}] to [{:g}, {:g}, {:g}] m: change its 'centre', or 'lower' and 'cells' of [fluid]",
            o.source, o.name, o.centre.x, o.centre.y, o.centre.z, grid.lower.x, grid.lower.y, grid.lower.z, upper.x,
            upper.y, upper.z));
    }
}

/// Obstacles with the triangles of their files.
std::vector<Obstacle> obstacles_of(const SceneSpec& scene, const FluidGrid& grid) {
    const double spacing = grid.h;
    std::vector<Obstacle> all = scene.obstacles;
    const std::filesystem::path directory = std::filesystem::path(scene.file).parent_path();
    for (Obstacle& o : all) {
        if (o.kind != ObstacleKind::mesh) continue;
        try {
            o.mesh = read_mesh((directory / o.file).string(), o.unit);
        } catch (const std::runtime_error& error) {
            throw InputError(fmt::format("{}: obstacle '{}': {}", o.source, o.name, error.what()));
        }
        if (o.least_axis() < spacing)
            throw InputError(fmt::format(
                "{}: obstacle '{}': the triangles of '{}' lie within {:.4g} x {:.4g} x {:.4g} m, too thin for cells of "
                "{:g} m: at least two cells; 'unit' [m] is the length of 1 in the file",
                o.source, o.name, o.file, o.sides_of_box().x, o.sides_of_box().y, o.sides_of_box().z, spacing));
    }
    for (const Obstacle& o : all) stop_outside(o, grid);
    return all;
}

} // namespace

FluidPlan plan_fluid(const PlanInput& input) {
    const SceneSpec& scene = input.scene;
    const std::span<const RodGroup> groups = input.groups;
    const FlowConstants constants = fitted_fluid(scene).constants();
    FluidPlan plan{.constants = constants,
                   .courant = scene.fluid->courant,
                   .velocity_formula = scene.fluid->velocity_formula,
                   .obstacles = obstacles_of(scene, constants.grid),
                   .forcing = scene.immersion.numbers(scene.fluid->density),
                   .names = names_for_formulas(scene),
                   .outputs = {},
                   .probes = scene.fluid_probes,
                   .single_loads = single_loads(scene, groups),
                   .measures_power = scene.output.fluid_power,
                   .speed = {},
                   .retraction = scene.immersion.retraction,
                   .coupling = scene.immersion.coupling,
                   .inner_inertia = scene.immersion.inner_inertia,
                   .follows_rods = scene.fluid->follows_rods,
                   .ranks_across_at = {}};
    if (const auto at = scene.fluid->key_source.find("ranks_across"); at != scene.fluid->key_source.end())
        plan.ranks_across_at = at->second;
    plan.outputs = outputs_of(scene, plan.constants.grid);
    const std::vector<StatedSpeed> stated = stated_speeds(scene, groups, input.loads);
    for (const StatedSpeed& one : stated) plan.stated = std::max(plan.stated, one.value);
    plan.speed = speed_of(plan, scene.fluid->expected_speed, stated);
    if (!groups.empty() && plan.coupling == RodCoupling::two_way && scene.immersion.forcing == ForcingKind::direct)
        plan.largest_slip = scene.fluid->largest_slip;
    plan.kinds = std::make_shared<const ImmersedKinds>(
        plan.constants.grid, ImmersedKinds::Numbers{plan.retraction * plan.constants.grid.h, plan.constants.density,
                                                    plan.inner_inertia, plan.coupling == RodCoupling::two_way,
                                                    scene.immersion.body_surface == SurfaceKind::sharp,
                                                    scene.immersion.rod_surface == SurfaceKind::sharp});
    for (const RodGroup& group : groups) plan.rods.push_back(rods_in_fluid(group, plan));
    plan.forcing.two_way = plan.two_way();
    plan.forcing.kinematic_viscosity = plan.constants.kinematic_viscosity;
    return plan;
}

} // namespace skein
