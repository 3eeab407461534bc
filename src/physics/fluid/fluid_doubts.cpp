#include "physics/fluid/fluid_doubts.hpp"

#include "physics/fluid/fluid_plan.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr double resolved = 2; // cells in a radius
constexpr double compared = 4; // cells in a radius of sharp surfaces, from which on drags were compared
constexpr std::string_view sharp_surfaces =
    "drag of sharp surfaces was compared with known values from four cells in radius on";
constexpr std::string_view flat_bodies =
    "at Re = 40 flat bodies of 1 cell in half the thickness have from 3 % too little to 6 % too much "
    "drag, those of 0.5 cells from 12 % too little to 35 % too much";

constexpr std::string_view spheres =
    "spheres of 3.6 cells in radius have 7 % too much drag in slow flow, and the error "
    "grows as the square of the spacing";

/// Radius of the cylinder that a rod acts as, in cells: apps/flow/README.md, thin rods in Stokes flow.
double seen_radius(double radius, bool on_axis) {
    struct Known {
        double radius, seen;
    };
    constexpr std::array<Known, 4> rings{{{1, 1.25}, {1.5, 1.74}, {2, 2.13}, {3, 3.02}}};
    if (on_axis) return 0.78;
    std::size_t i = 1;
    while (i + 1 < rings.size() && radius > rings[i].radius) ++i;
    const Known &low = rings[i - 1], &high = rings[i];
    return low.seen + (radius - low.radius) / (high.radius - low.radius) * (high.seen - low.seen);
}

/// Somewhere more than twice as wide as thick, or a plate without edges.
bool is_flat(const RodGroup& group, const FluidGrid& grid) {
    if (spans_box(group, grid)) return true;
    bool flat = false;
    for_each_kind(group, [&](const RodGroup& kind, double) {
        for (std::size_t k = 0; k < kind.element.size(); ++k) {
            const HalfAxes axes = half_axes(kind, k);
            flat |= std::max(axes.along_d1, axes.along_d2) > 2 * std::min(axes.along_d1, axes.along_d2);
        }
    });
    return flat;
}

/// Rods or bodies that keep markers although the scene asks for sharp surfaces, and the cure.
std::string of_markers_in_place(const RodsInFluid& rods, double spacing) {
    const std::string who = fmt::format("{}.{}: immersion.{}_surface = \"sharp\" does not apply, and {} markers",
                                        rods.body ? "bodies" : "rods", rods.name, rods.body ? "body" : "rod",
                                        rods.body ? "these bodies have" : "these rods have");
    const double half = rods.body ? rods.least_axis : rods.thickest;
    return who + fmt::format(": the {} part has {:.3g} cells in half its thickness, below 1; fluid.spacing "
                             "= {:.3g} at most",
                             rods.body ? "thinnest" : "thickest", half, half * spacing);
}

/// Sharp surfaces thinner than those whose drag was compared.
std::string of_thin_sharp(const RodsInFluid& rods, double spacing) {
    return fmt::format("{}.{}: {:.3g} cells in half the thickness, too few for the fluid: {}; fluid.spacing = {:.3g} "
                       "gives four cells",
                       rods.body ? "bodies" : "rods", rods.name, rods.least_axis, sharp_surfaces,
                       rods.least_axis * spacing / compared);
}

/// Rods whose thin parts have markers beside a sharp surface.
std::string of_thin_parts(const RodsInFluid& rods, double spacing) {
    return fmt::format(
        "rods.{}: {:.3g} % of their length, down to {:.3g} cells in half the thickness, is too thin for a "
        "sharp surface and acts by markers, over three cells; fluid.spacing = {:.3g} gives a sharp "
        "surface all along",
        rods.name, 100 * (1 - rods.sharp), rods.least_axis,
        spacing * std::min(rods.least_axis / all_sharp, rods.thickest / thick_for_sharp));
}

std::string of_rods(const RodsInFluid& rods, const RodGroup& group, const FluidGrid& grid) {
    if (rods.sharp == 1) return of_thin_sharp(rods, grid.h);
    if (rods.sharp > 0) return of_thin_parts(rods, grid.h);
    const bool flat = is_flat(group, grid);
    double shortest = HUGE_VAL;
    for_each_kind(group,
                  [&](const RodGroup& kind, double) { shortest = std::min(shortest, kind.spec().shape.length); });
    const double spacing = grid.h, radius = rods.least_axis, length = shortest / spacing;
    const auto has = [&](SectionMarkers kind) { return nth(rods.has, kind); };
    const std::string what =
        fmt::format("rods.{}: {:.3g} cells in {}", rods.name, radius, flat ? "half the thickness" : "radius");
    const std::string cure = fmt::format("; fluid.spacing = {:.3g} gives two cells", radius * spacing / resolved);
    if (flat) return what + ", too few for the fluid: " + std::string(flat_bodies) + cure;
    const bool on_axis = has(SectionMarkers::centre_line);
    const double error = drag_error(radius, length, on_axis);
    std::string text =
        what + fmt::format(", too few for the fluid, which sees about {:.2g} cells", seen_radius(radius, on_axis));
    if (std::isfinite(error))
        text += fmt::format(": in slow flow the drag across it will be about {:.2g} times its own ({:+.1f} %)",
                            1 + error, 100 * error);
    text +=
        "; at Re = 40 cylinders of 1.6 cells in radius have 4 to 12 % too little drag, those of 1 cell twice their own";
    constexpr double close = 0.02;
    if (on_axis && !(std::abs(error) < close))
        text += fmt::format("; fluid.spacing = {:.3g} makes the width right in slow flow", radius * spacing / 0.78);
    return text + cure;
}

/// True if some rod of a group with a sharp surface is long beside its thinnest part.
bool some_are_slender(const RodGroup& group, const FluidPlan& fluid) {
    constexpr double slender = 5; // length over thickness
    bool found = false;
    for_each_kind(group, [&](const RodGroup& kind, double) {
        const bool plate = spans_box(kind, fluid.constants.grid);
        double length = 0, least = HUGE_VAL;
        for (std::size_t k = 0; k < kind.element.size(); ++k) {
            const HalfAxes axes = half_axes(kind, k);
            least = std::min({least, axes.along_d1, plate ? axes.along_d1 : axes.along_d2});
            length += kind.element[k].rest_length;
        }
        found |= fluid.kinds->of(kind, 0).sharp && length > slender * 2 * least;
    });
    return found;
}

/// Length of the shortest element of a group that acts by a sharp surface, over the spacing.
double shortest_sharp_element(const RodGroup& group, const FluidPlan& fluid) {
    double shortest = HUGE_VAL;
    for_each_kind(group, [&](const RodGroup& kind, double) {
        const ImmersedKinds::Kind& in_fluid = fluid.kinds->of(kind, 0);
        if (!in_fluid.sharp) return;
        for (std::size_t k = 0; k < kind.element.size(); ++k)
            if (in_fluid.sharp_shares[k] > 0 || in_fluid.sharp_shares[k + 1] > 0)
                shortest = std::min(shortest, kind.element[k].rest_length);
    });
    return shortest / fluid.constants.grid.h;
}

/// Elements of which velocity nodes sample little, so that they have less inertia than they should. theory.md section
/// 30
std::string of_short_elements(const RodsInFluid& rods, double shortest, double spacing) {
    return fmt::format(
        "rods.{}: elements of {:.3g} cells are too short for a sharp surface of rods of {:.3g} times the "
        "fluid's density: few velocity nodes lie in one, and short waves may grow; elements of {:.3g} m, "
        "or fluid.spacing = {:.3g}, are long enough",
        rods.name, shortest, rods.density_ratio, spacing, shortest * spacing);
}

/// Deformations that move no fluid around a light rod, whose added inertia comes back later. theory.md (156)
std::string of_light_rods(const RodsInFluid& rods) {
    return fmt::format(
        "rods.{}: its density is {:.3g} times the fluid's, and its surface is sharp: stretch and twist of "
        "slender rods that are lighter than the fluid may grow slowly",
        rods.name, rods.density_ratio);
}

std::string of_ends_within(const RodsInFluid& rods, const Obstacle& o) {
    return fmt::format("rods.{}: an end of these rods, which have sharp surfaces, lies within obstacle '{}', which has "
                       "markers: they push "
                       "the fluid within a rod, which may shorten without limit; obstacle.surface = \"sharp\" holds",
                       rods.name, o.name);
}

/// Places of both ends of a rod at the start, lab, m; none of a ring.
std::vector<Vec3d> ends_of(const RodGroup& group, std::int64_t i) {
    if (group.closed()) return {};
    std::vector<Slot<1>> rod(to_index(group.slots()));
    group.start_state(i, rod);
    return {lane(rod.front().position, 0), lane(rod.back().position, 0)};
}

/// The first obstacle with markers within which rods begin or end. Of a file a rank has some of the rods.
const Obstacle* markers_around_end(const RodGroup& group, const std::vector<Obstacle>& obstacles) {
    if (std::all_of(obstacles.begin(), obstacles.end(), [](const Obstacle& o) { return o.is_sharp(); })) return nullptr;
    std::vector<Vec3d> ends;
    const auto add = [&](std::int64_t i) {
        for (const Vec3d& end : ends_of(group, i)) ends.push_back(end);
    };
    if (group.places().from_file())
        for (const std::int64_t i : group.places().held()) add(i);
    else
        for (std::int64_t i = 0; i < group.count(); ++i) add(i);
    for (const Obstacle& o : obstacles) {
        if (o.is_sharp()) continue;
        const std::unique_ptr<Surface> shape = o.shape();
        const Mat3d axes = o.axes_at(0);
        for (const Vec3d& end : ends)
            if (shape->distance(axes * (end - o.place_at(0))) < 0) return &o;
    }
    return nullptr;
}

std::string of_bodies(const RodsInFluid& bodies, double spacing) {
    if (bodies.sharp == 1) return of_thin_sharp(bodies, spacing);
    return fmt::format("bodies.{}: {:.3g} cells in half the thickness of a part, too few for the fluid: {}; "
                       "fluid.spacing = {:.3g} gives two cells",
                       bodies.name, bodies.least_axis, spheres, bodies.least_axis * spacing / resolved);
}

std::string of_obstacle(const Obstacle& o, double least, double spacing) {
    const Vec3d sides = o.sides_of_box();
    const bool sphere = o.kind == ObstacleKind::sphere,
               flat = !sphere && std::max(sides.x, sides.y) > 4 * least; // twice as wide as thick
    const std::string_view known =
        o.is_sharp() ? sharp_surfaces
        : sphere     ? spheres
        : flat       ? flat_bodies
                     : "at Re = 40 cylinders of 3.3 cells in radius have up to 7 % too little drag, those of 1.6 "
                       "cells 4 to 12 %, those of 1 cell twice their own";
    return fmt::format(
        "obstacle '{}': {:.3g} cells in {} are too few for the fluid: {}; fluid.spacing = {:.3g} gives {} cells",
        o.name, least / spacing, flat ? "half the thickness" : "radius", known,
        least / (o.is_sharp() ? compared : resolved), o.is_sharp() ? "four" : "two");
}

} // namespace

double drag_error(double radius, double length, bool on_axis) {
    constexpr double slender = 5, ends = 0.089; // 4 pi mu U L/(ln(L/a) + 0.089), of a cylinder of 20 diameters
    const double seen = seen_radius(radius, on_axis);
    if (!(length > slender * std::max(seen, radius))) return NAN;
    return (std::log(length / radius) + ends) / (std::log(length / seen) + ends) - 1;
}

std::vector<std::string> fluid_doubts(const FluidPlan& fluid, std::span<const RodGroup> groups) {
    std::vector<std::string> found;
    const double h = fluid.constants.grid.h, rounding = 1e-9;
    for (std::size_t g = 0; g < fluid.rods.size(); ++g)
        if (fluid.rods[g].least_axis < resolved * (1 - rounding))
            found.push_back(fluid.rods[g].body ? of_bodies(fluid.rods[g], h)
                                               : of_rods(fluid.rods[g], groups[g], fluid.constants.grid));
    for (const RodsInFluid& rods : fluid.rods)
        if (rods.asks_sharp && rods.sharp == 0) found.push_back(of_markers_in_place(rods, h));
    constexpr double light = 1; // density over the fluid's
    for (std::size_t g = 0; g < fluid.rods.size(); ++g) {
        const RodsInFluid& rods = fluid.rods[g];
        if (rods.body || rods.sharp == 0 || !rods.feels_fluid) continue;
        if (const Obstacle* o = markers_around_end(groups[g], fluid.obstacles))
            found.push_back(of_ends_within(rods, *o));
        constexpr double short_elements = 0.8, heavy = 1.5; // cells; density over the fluid's
        if (const double shortest = shortest_sharp_element(groups[g], fluid);
            shortest < short_elements && rods.density_ratio < heavy)
            found.push_back(of_short_elements(rods, shortest, h));
        if (rods.density_ratio < light * (1 - rounding) && some_are_slender(groups[g], fluid))
            found.push_back(of_light_rods(rods));
    }
    for (const Obstacle& o : fluid.obstacles) {
        const double least = o.least_axis();
        if (least < resolved * (1 - rounding) * h) found.push_back(of_obstacle(o, least, h));
    }
    return found;
}

} // namespace skein
