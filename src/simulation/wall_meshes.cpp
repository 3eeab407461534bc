#include "simulation/wall_meshes.hpp"

#include "placement/packing.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

constexpr int around = 64, upwards = 32;    ///< facets of a tube and a ball
constexpr std::int64_t looked_at = 1 << 14; // rods of a group whose places tell how far it reaches

struct Bounds {
    Vec3d lower{HUGE_VAL, HUGE_VAL, HUGE_VAL}, upper{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    void take(const Vec3d& p, double r) {
        lower = {std::min(lower.x, p.x - r), std::min(lower.y, p.y - r), std::min(lower.z, p.z - r)};
        upper = {std::max(upper.x, p.x + r), std::max(upper.y, p.y + r), std::max(upper.z, p.z + r)};
    }
};

/// Part of a convex polygon on the side of a plane that its normal points to (Sutherland, Hodgman).
std::vector<Vec3d> cut(const std::vector<Vec3d>& polygon, const Vec3d& point, const Vec3d& normal, double tolerance) {
    std::vector<Vec3d> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double at_a = dot(a - point, normal) + tolerance, at_b = dot(b - point, normal) + tolerance;
        if (at_a >= 0) kept.push_back(a);
        if ((at_a >= 0) != (at_b >= 0)) kept.push_back(a + (at_a / (at_a - at_b)) * (b - a));
    }
    return kept;
}

/// Planes at rest do, and those that go along with a wall, as the sides of a box.
bool bounds(const Wall& plane, const Wall& wall) {
    if (plane.kind != WallKind::plane || !plane.stands || plane.servo.drives()) return false;
    const Vec3d apart = plane.velocity - wall.velocity;
    return !plane.moves_steadily() || (!wall.servo.drives() && dot(apart, apart) == 0 && plane.from == wall.from);
}

} // namespace

WallMeshes::WallMeshes(const Communicator& comm, const Walls& walls, std::span<const RodGroup> groups,
                       std::span<const LocalRod> own)
    : walls_(walls) {
    Bounds bounds;
    std::vector<Capsule> elements;
    for (const LocalRod& rod : own) {
        const RodGroup& group = nth(groups, rod.group);
        if (rod.index % (group.count() / looked_at + 1) != 0) continue;
        elements.clear();
        group.append_capsules(rod.index, elements);
        for (const Capsule& c : elements) {
            bounds.take(c.start, c.radius);
            bounds.take(c.end, c.radius);
        }
    }
    for (double* x : {&bounds.lower.x, &bounds.lower.y, &bounds.lower.z}) *x = comm.min(*x);
    for (double* x : {&bounds.upper.x, &bounds.upper.y, &bounds.upper.z}) *x = comm.max(*x);
    for (const Wall& wall : walls.wall) {
        if (wall.kind == WallKind::ball) bounds.take(wall.point, wall.radius);
        if (wall.kind == WallKind::tube) {
            const Vec3d middle = 0.5 * (bounds.lower + bounds.upper);
            bounds.take(wall.point + dot(middle - wall.point, wall.axis) * wall.axis, wall.radius);
        }
    }
    centre_ = 0.5 * (bounds.lower + bounds.upper);
    reach_ = 0.75 * norm(bounds.upper - bounds.lower);
}

WallMeshes::Polygon WallMeshes::quad(const Vec3d& point, const Vec3d& normal) const {
    const Vec3d foot = centre_ - dot(centre_ - point, normal) * normal;
    const auto [u, v] = directions_across(normal);
    return {foot - reach_ * u - reach_ * v, foot + reach_ * u - reach_ * v, foot + reach_ * u + reach_ * v,
            foot - reach_ * u + reach_ * v};
}

std::vector<WallMeshes::Polygon> WallMeshes::tube(const Wall& wall) const {
    const auto [u, v] = directions_across(wall.axis);
    const Vec3d middle = wall.point + dot(centre_ - wall.point, wall.axis) * wall.axis;
    std::vector<Polygon> all;
    for (int i = 0; i < around; ++i) {
        const auto at = [&, u = u, v = v](int k) {
            const double angle = 2 * M_PI * k / around;
            return middle + wall.radius * (std::cos(angle) * u + std::sin(angle) * v);
        };
        const Vec3d along = reach_ * wall.axis;
        all.push_back({at(i) - along, at(i + 1) - along, at(i + 1) + along, at(i) + along});
    }
    return all;
}

std::vector<WallMeshes::Polygon> WallMeshes::ball(const Wall& wall) const {
    const auto at = [&](int i, int j) {
        const double longitude = 2 * M_PI * i / around, latitude = M_PI * j / upwards;
        return wall.point + wall.radius * Vec3d{std::sin(latitude) * std::cos(longitude),
                                                std::sin(latitude) * std::sin(longitude), std::cos(latitude)};
    };
    std::vector<Polygon> all;
    for (int j = 0; j < upwards; ++j)
        for (int i = 0; i < around; ++i) all.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)});
    return all;
}

std::vector<WallMeshes::Polygon> WallMeshes::facets(std::size_t wall) const {
    const Wall& one = walls_.wall[wall];
    switch (one.kind) {
    case WallKind::tube:
        return tube(one);
    case WallKind::ball:
        return ball(one);
    default:
        return {quad(one.point, one.normal)};
    }
}

PolygonMesh WallMeshes::at(double time) const {
    PolygonMesh mesh;
    for (std::size_t w = 0; w < walls_.count(); ++w) {
        if (!walls_.wall[w].stands) continue;
        const Vec3d offset = walls_.at(w, time).offset;
        for (Polygon polygon : facets(w)) {
            for (Vec3d& p : polygon) p = p + offset;
            for (std::size_t other = 0; other < walls_.count(); ++other) {
                const Wall& plane = walls_.wall[other];
                if (other != w && bounds(plane, walls_.wall[w]) && !polygon.empty())
                    polygon = cut(polygon, plane.point + walls_.at(other, time).offset, plane.normal, 1e-9 * reach_);
            }
            if (polygon.size() < 3) continue;
            std::vector<std::int32_t>& corners = mesh.polygon.emplace_back();
            for (const Vec3d& p : polygon) {
                corners.push_back(static_cast<std::int32_t>(mesh.points.size()));
                mesh.points.push_back(p);
            }
            mesh.number.push_back(static_cast<std::int32_t>(w));
        }
    }
    return mesh;
}

} // namespace skein
