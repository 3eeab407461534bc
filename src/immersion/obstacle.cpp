#include "immersion/obstacle.hpp"

#include "immersion/body_surface.hpp"
#include "immersion/markers.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

namespace {

void visit_shape(FieldVisitor& f, Obstacle& o) {
    f.choice({.name = "kind",
              .unit = "",
              .text = "sphere; cylinder along z through the whole box; capsule: cylinder with half balls at both ends; "
                      "box, a plate if it is flat; ellipsoid; mesh: closed surface of triangles from a file"},
             o.kind, obstacle_names);
    f.visit({.name = "centre",
             .unit = "m",
             .text = "centre at the start; z has no meaning for a cylinder; mesh: place of the origin of its file",
             .required = true},
            o.centre);
    f.visit({.name = "radius",
             .unit = "m",
             .text = "radius; for a cylinder with second_radius, half axis along x; box: radius of its edges",
             .at_least = 0},
            o.radius);
    f.visit({.name = "second_radius",
             .unit = "m",
             .text = "cylinder: half axis along y; 0: equal to `radius`",
             .at_least = 0},
            o.second_radius);
    f.visit({.name = "length",
             .unit = "m",
             .text = "capsule: distance of the centres of its round ends, which lie along its `axis`",
             .at_least = 0},
            o.length);
    f.visit({.name = "sides", .unit = "m", .text = "box: sides along its own x, y and z, including rounded edges"},
            o.sides);
    f.visit({.name = "half_axes", .unit = "m", .text = "ellipsoid: half axes along its own x, y and z"}, o.half_axes);
    f.visit({.name = "file",
             .text = "mesh: path relative to the scene; .stl (text or binary) or .obj, whose triangles have corners "
                     "counter-clockwise as seen from outside"},
            o.file);
    f.visit({.name = "unit",
             .unit = "m",
             .text = "mesh: length of 1 in its coordinates; 1e-3 for a file in millimetres",
             .above = 0},
            o.unit);
    f.visit({.name = "axis", .unit = "-", .text = "direction of its own z at the start"}, o.axis);
    f.visit_optional({.name = "normal",
                      .unit = "-",
                      .text = "direction of its own x at the start, made orthogonal to `axis`; default: x, or y for an "
                              "axis along x"},
                     o.normal);
}

} // namespace

void Obstacle::fields(FieldVisitor& f) {
    f.visit({.name = "name", .unit = "", .text = "name of its columns in the time series"}, name);
    visit_shape(f, *this);
    f.visit({.name = "velocity", .unit = "m/s", .text = "steady velocity"}, velocity);
    f.visit({.name = "angular_velocity", .unit = "rad/s", .text = "steady angular velocity about the centre"},
            angular_velocity);
    f.visit({.name = "amplitude", .unit = "m", .text = "amplitude of a sinusoidal displacement"}, amplitude);
    f.visit({.name = "frequency", .unit = "Hz", .text = "frequency of this displacement", .at_least = 0}, frequency);
    f.choice({.name = "surface",
              .unit = "",
              .text =
                  "markers: points within the surface push the fluid, spread over three cells; sharp: velocities are "
                  "set within the body, and next to it the Laplacian has the place at which the surface cuts the "
                  "grid line"},
             surface, surface_names);
    f.visit({.name = "retraction",
             .unit = "-",
             .text = "surface = \"markers\": inward offset of the markers, in cells (immersed bodies appear too "
                     "large); 0.4 fits the drag at "
                     "Re = 100 with two sweeps of an explicit scheme, 0.3 the drag in Stokes flow",
             .at_least = 0,
             .at_most = 2},
            retraction);
}

Vec3d Obstacle::place_at(double time) const {
    return centre + time * velocity + std::sin(2 * std::numbers::pi * frequency * time) * amplitude;
}
Vec3d Obstacle::velocity_at(double time) const {
    const double rate = 2 * std::numbers::pi * frequency;
    return velocity + rate * std::cos(rate * time) * amplitude;
}
Mat3d Obstacle::axes_at(double time) const {
    const Vec3d d3 = skein::unit(axis),
                wanted = normal.value_or(std::abs(d3.x) > 1 - 1e-9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0}),
                d1 = skein::unit(wanted - dot(wanted, d3) * d3), d2 = cross(d3, d1);
    if (!turns()) return {d1, d2, d3};
    const double rate = norm(angular_velocity), c = std::cos(rate * time), s = std::sin(rate * time);
    const Vec3d about = (1 / rate) * angular_velocity;
    const auto turned = [&](const Vec3d& d) { return c * d + s * cross(about, d) + ((1 - c) * dot(about, d)) * about; };
    return {turned(d1), turned(d2), turned(d3)};
}
bool Obstacle::moves() const { return norm(velocity) > 0 || turns() || (norm(amplitude) > 0 && frequency > 0); }

double Obstacle::turning_speed() const {
    if (!turns()) return 0;
    const Vec3d extent = shape()->extent();
    const double across = std::hypot(extent.x, extent.y);
    return norm(angular_velocity) * (std::isfinite(extent.z) ? std::max(extent.x, extent.z) : across);
}

BodyShape::Part Obstacle::part() const {
    if (kind == ObstacleKind::capsule)
        return {.from = {0, 0, -0.5 * length}, .to = {0, 0, 0.5 * length}, .radius = radius};
    return {.from = {0, 0, 0},
            .to = {0, 0, 0},
            .radius = radius,
            .half = 0.5 * sides - Vec3d{radius, radius, radius},
            .box = true};
}

Vec3d Obstacle::sides_of_box() const {
    switch (kind) {
    case ObstacleKind::sphere:
        return {2 * radius, 2 * radius, 2 * radius};
    case ObstacleKind::cylinder:
        return {2 * radius, 2 * second(), Surface::unbounded};
    case ObstacleKind::capsule:
        return {2 * radius, 2 * radius, length + 2 * radius};
    case ObstacleKind::box:
        return sides;
    case ObstacleKind::ellipsoid:
        return 2 * half_axes;
    case ObstacleKind::mesh:
        return mesh ? mesh->upper() - mesh->lower() : Vec3d{0, 0, 0};
    }
    return {0, 0, 0};
}

double Obstacle::least_axis() const {
    const Vec3d sides = sides_of_box();
    return 0.5 * std::min({sides.x, sides.y, sides.z});
}

std::unique_ptr<Surface> Obstacle::shape() const {
    const bool turned = turns() || normal;
    switch (kind) {
    case ObstacleKind::sphere:
        return std::make_unique<SphereSurface>(radius);
    case ObstacleKind::cylinder:
        return std::make_unique<TubeSurface>(radius, second(), turned);
    case ObstacleKind::ellipsoid:
        return std::make_unique<EllipsoidSurface>(half_axes);
    case ObstacleKind::mesh:
        return std::make_unique<MeshSurface>(mesh);
    case ObstacleKind::capsule:
    case ObstacleKind::box:
        break;
    }
    const BodyShape::Part one = part();
    return std::make_unique<PartsSurface>(std::vector{one}, 0.5 * norm(one.to - one.from) + one.cover());
}

Solid Obstacle::solid(const FluidGrid& grid) const {
    const double pi = std::numbers::pi;
    switch (kind) {
    case ObstacleKind::sphere:
        return solid_sphere({0, 0, 0}, radius);
    case ObstacleKind::capsule: {
        const BodyShape::Part ends = part();
        return solid_capsule(ends.from, ends.to, radius);
    }
    case ObstacleKind::box:
        return solid_box({0, 0, 0}, part().half, radius);
    case ObstacleKind::ellipsoid: {
        const Vec3d a = half_axes, square = 0.2 * scale(a, a);
        return {
            4.0 / 3 * pi * a.x * a.y * a.z, {0, 0, 0}, {square.y + square.z, square.x + square.z, square.x + square.y}};
    }
    case ObstacleKind::mesh:
        return mesh->solid();
    case ObstacleKind::cylinder:
        break;
    }
    const double depth = grid.h * grid.cells[2], a = 0.25 * radius * radius, b = 0.25 * second() * second(),
                 c = depth * depth / 12;
    return {pi * radius * second() * grid.h * grid.cells[2], {0, 0, 0}, {b + c, a + c, a + b}};
}

std::vector<Vec3d> Obstacle::markers(const FluidGrid& grid) const {
    const double within = retraction * grid.h;
    if (kind == ObstacleKind::sphere) return sphere_markers(std::max(radius - within, 0.0), grid.h);
    const Mat3d axes = axes_at(0);
    std::vector<Vec3d> places;
    if (kind == ObstacleKind::cylinder) {
        const double low = grid.lower.z;
        places = tube_markers(std::max(radius - within, 0.0), std::max(second() - within, 0.0), low,
                              low + grid.h * grid.cells[2], grid.h);
        if (!normal) return places;
    } else places = part_markers(part(), grid.h, within);
    for (Vec3d& at : places) at = transpose_times(axes, at);
    return places;
}

} // namespace skein
