#include "immersion/obstacle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

void Obstacle::fields(FieldVisitor& f) {
    f.visit({.name = "name", .unit = "", .text = "of its columns in the time series"}, name);
    f.choice({.name = "kind", .unit = "", .text = "sphere, or cylinder along z through the whole box"}, kind, obstacle_names);
    f.visit({.name = "centre", .unit = "m", .text = "of it at the start; of a cylinder z has no meaning", .required = true},
            centre);
    f.visit({.name = "radius",
             .unit = "m",
             .text = "radius; of a cylinder with a second one that along x",
             .required = true,
             .above = 0},
            radius);
    f.visit({.name = "second_radius", .unit = "m", .text = "of a cylinder: half axis along y; 0: as `radius`", .at_least = 0},
            second_radius);
    f.visit({.name = "velocity", .unit = "m/s", .text = "steady velocity"}, velocity);
    f.visit({.name = "amplitude", .unit = "m", .text = "of a sine that is added to its place"}, amplitude);
    f.visit({.name = "frequency", .unit = "Hz", .text = "of that sine", .at_least = 0}, frequency);
    f.visit({.name = "retraction",
             .unit = "-",
             .text =
                 "how far markers lie within the surface, over the spacing of the grid: a body acts as if it were larger than its "
                 "markers. 0.4 is for the drag at Re = 100 with two sweeps of an explicit scheme, 0.3 for that of Stokes flow",
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

double Obstacle::volume(const FluidGrid& grid) const {
    const double pi = std::numbers::pi;
    if (kind == ObstacleKind::sphere) return 4.0 / 3 * pi * radius * radius * radius;
    return pi * radius * (second_radius > 0 ? second_radius : radius) * grid.h * grid.cells[2];
}

std::vector<Vec3d> Obstacle::markers(const FluidGrid& grid) const {
    const double within = retraction * grid.h;
    if (kind == ObstacleKind::sphere) return sphere_markers(std::max(radius - within, 0.0), grid.h);
    const double other = second_radius > 0 ? second_radius : radius, low = grid.lower.z;
    return tube_markers(std::max(radius - within, 0.0), std::max(other - within, 0.0), low, low + grid.h * grid.cells[2], grid.h);
}

namespace {

bool some_move(const std::vector<Obstacle>& obstacles) {
    return std::any_of(obstacles.begin(), obstacles.end(), [](const Obstacle& o) { return o.moves(); });
}

} // namespace

ObstacleForcing::ObstacleForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                                 const ForcingNumbers& numbers, std::vector<Obstacle> obstacles)
    : grid_(grid), rank_(comm.rank()), ranks_(comm.size()), obstacles_(std::move(obstacles)),
      forcing_(
          comm, threads, grid, numbers, obstacles_.size(), [this](double time, Markers& markers) { place(time, markers); },
          some_move(obstacles_)) {
    for (const Obstacle& o : obstacles_) about_centre_.push_back(o.markers(grid_));
}

/// A marker is the rank's that has its plane.
void ObstacleForcing::place(double time, Markers& markers) const {
    const int planes = grid_.cells[2];
    std::int64_t identity = 0;
    for (std::size_t o = 0; o < obstacles_.size(); ++o) {
        Vec3d centre = obstacles_[o].place_at(time);
        if (obstacles_[o].kind == ObstacleKind::cylinder) centre.z = 0;
        const Vec3d velocity = obstacles_[o].velocity_at(time);
        for (const Vec3d& at : about_centre_[o]) {
            const Vec3d place = centre + at;
            const auto plane = static_cast<std::int64_t>(std::floor((place.z - grid_.lower.z) / grid_.h));
            const std::int64_t inside =
                grid_.periodic(2) ? (plane % planes + planes) % planes : std::clamp<std::int64_t>(plane, 0, planes - 1);
            ++identity;
            if (rank_of_plane(static_cast<int>(inside), planes, ranks_) != rank_) continue;
            markers.place.push_back(place), markers.velocity.push_back(velocity);
            markers.identity.push_back(identity), markers.body.push_back(static_cast<std::uint32_t>(o));
        }
    }
}

Vec3d ObstacleForcing::force(std::size_t obstacle, double density, double time) const {
    if (!(time > from_)) return {0, 0, 0};
    const Obstacle& o = obstacles_[obstacle];
    // The fluid within the markers moves with the body: its inertia is no force on the body.
    const Vec3d inside = o.volume(grid_) * (o.velocity_at(time) - o.velocity_at(from_));
    return (density / (time - from_)) * (inside - forcing_.given()[obstacle]);
}

} // namespace skein
