#include "rod_body_contact.hpp"

#include <algorithm>
#include <cmath>

namespace skein::replay {

namespace {

/// The published box of a cylinder takes the transpose of its frame times (R, R, L/2), component by component.
Box box_of(const RigidBody& body) {
    const double r = body.radius;
    Vec3d half{r, r, r};
    if (body.shape == RigidBody::Shape::cylinder) {
        const Vec3d h = transpose_times(frame(body.slot), Vec3d{r, r, 0.5 * body.length});
        half = {std::abs(h.x), std::abs(h.y), std::abs(h.z)};
    }
    return {body.position() - half, body.position() + half};
}

Vec3d nearest_point(const Vec3d& start, const Vec3d& edge, const Vec3d& point) {
    return start + std::clamp(dot(edge, point - start) / dot(edge, edge), 0.0, 1.0) * edge;
}

} // namespace

RodBodyContact::RodBodyContact(const Entry& e)
    : stiffness(e["k"].number()), damping(e["nu"].number()), friction(e["friction_coefficient"].number()),
      velocity_damping(e["velocity_damping_coefficient"].number()) {
    e.expect_keys({"kind", "system", "other", "k", "nu", "friction_coefficient", "velocity_damping_coefficient"});
}

Vec3d RodBodyContact::force(const Vec3d& apart, double radii, const Vec3d& velocity) const {
    const double distance = norm(apart), overlap = radii - distance;
    if (!(overlap > 0)) return {0, 0, 0};
    const Vec3d d = (1 / distance) * apart;
    const double approach = dot(velocity, d), normal = 0.5 * (stiffness * overlap - damping * approach);
    const Vec3d slip = velocity - approach * d;
    const double speed = norm(slip);
    return normal * d - (std::min(velocity_damping * speed, friction * std::abs(normal)) / (speed + 1e-14)) * slip;
}

void RodBodyContact::add(Rod& rod, RigidBody& body) const {
    const bool cylinder = body.shape == RigidBody::Shape::cylinder;
    const auto segments = segments_of(rod);
    if (replay::box_of(rod, largest_radius(segments) + (cylinder ? largest_length(segments) : 0.0))
            .apart_from(box_of(body)))
        return;
    const Vec3d axis = body.length * body.axis(), tip = body.position() - 0.5 * axis;
    Vec3d force_on_body{0, 0, 0}, torque{0, 0, 0}; // lab
    for (std::size_t k = 0; k < segments.size(); ++k) {
        const Segment& s = segments[k];
        const Vec3d centre = s.start + 0.5 * s.edge;
        const double radii = s.radius + body.radius;
        if (norm(centre - (cylinder ? tip : body.position())) >= radii + (s.length + body.length)) continue;
        const Nearest pair =
            cylinder ? nearest(centre, s.edge, tip, axis)
                     : Nearest{body.position() - nearest_point(centre, s.edge, body.position()), body.position()};
        const Vec3d f = force(pair.gap, radii, body.velocity() - mean_velocity(rod, k));
        add_to_element(rod, k, -f);
        force_on_body += 2.0 * f;
        torque += cross(pair.point_of_b - body.position(), 2.0 * f);
    }
    body.force += force_on_body;
    if (cylinder) body.couple += frame(body.slot) * torque;
}

} // namespace skein::replay
