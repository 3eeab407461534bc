#include "immersion/obstacle.hpp"

#include "immersion/markers.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

void Obstacle::fields(FieldVisitor& f) {
    f.visit({.name = "name", .unit = "", .text = "name of its columns in the time series"}, name);
    f.choice({.name = "kind", .unit = "", .text = "sphere, or cylinder along z through the whole box"}, kind,
             obstacle_names);
    f.visit({.name = "centre",
             .unit = "m",
             .text = "centre at the start; z has no meaning for a cylinder",
             .required = true},
            centre);
    f.visit({.name = "radius",
             .unit = "m",
             .text = "radius; for a cylinder with second_radius, half axis along x",
             .required = true,
             .above = 0},
            radius);
    f.visit({.name = "second_radius",
             .unit = "m",
             .text = "cylinder: half axis along y; 0: equal to `radius`",
             .at_least = 0},
            second_radius);
    f.visit({.name = "velocity", .unit = "m/s", .text = "steady velocity"}, velocity);
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
bool Obstacle::moves() const { return norm(velocity) > 0 || (norm(amplitude) > 0 && frequency > 0); }

double Obstacle::least_axis() const {
    return kind == ObstacleKind::cylinder && second_radius > 0 ? std::min(radius, second_radius) : radius;
}
std::unique_ptr<Surface> Obstacle::shape() const {
    if (kind == ObstacleKind::sphere) return std::make_unique<SphereSurface>(radius);
    return std::make_unique<TubeSurface>(radius, second_radius > 0 ? second_radius : radius);
}

double Obstacle::volume(const FluidGrid& grid) const {
    const double pi = std::numbers::pi;
    if (kind == ObstacleKind::sphere) return 4.0 / 3 * pi * radius * radius * radius;
    return pi * radius * (second_radius > 0 ? second_radius : radius) * grid.h * grid.cells[2];
}

std::vector<Vec3d> Obstacle::markers(const FluidGrid& grid) const {
    const double within = retraction * grid.h;
    if (kind == ObstacleKind::sphere) return sphere_markers(std::max(radius - within, 0.0), grid.h);
    const double other = second_radius > 0 ? second_radius : radius, low = grid.lower.z;
    return tube_markers(std::max(radius - within, 0.0), std::max(other - within, 0.0), low,
                        low + grid.h * grid.cells[2], grid.h);
}

} // namespace skein
