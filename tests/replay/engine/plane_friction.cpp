#include "plane_friction.hpp"

#include "segments.hpp"

#include <algorithm>
#include <cmath>

namespace skein::replay {

namespace {

double sign(double a) { return static_cast<double>((a > 0) - (a < 0)); }

/// Of forward (v > 0) and backward, half of both at 0.
double along(const Vec3d& mu, double v) { return 0.5 * (mu.x * (1 + sign(v)) + mu.y * (1 - sign(v))); }

Vec3d add_to_all(const Vec3d& a, double s) { return {a.x + s, a.y + s, a.z + s}; }

/// An element in contact.
struct Touch {
    std::size_t k;
    double radius, response;             ///< m; R, N
    Vec3d axial, rolling;                ///< a, b
    Vec3d arm;                           ///< p, m
    double axial_sticks, rolling_sticks; ///< s_a, s_b
    double axial_speed;                  ///< m/s
    Vec3d slip;                          ///< u
};

Vec3d force_at_node(const Rod& rod, std::size_t i) {
    return lane(rod.internal[i].force, 0) + lane(rod.external[i].force, 0);
}

Vec3d force_on_element(const Rod& rod, std::size_t k) {
    Vec3d force = 0.5 * (force_at_node(rod, k) + force_at_node(rod, k + 1));
    if (k == 0) force += 0.5 * force_at_node(rod, 0);
    if (k + 1 == rod.elements()) force += 0.5 * force_at_node(rod, k + 1);
    return force;
}

void add_to_nodes(Rod& rod, std::size_t k, const Vec3d& force) {
    for (const std::size_t i : {k, k + 1}) rod.external[i].force += broadcast<1>(0.5 * force);
}

/// With the couple that a force at the contact point has.
void add_at_contact(Rod& rod, const Touch& t, const Vec3d& force) {
    add_to_nodes(rod, t.k, force);
    rod.external[t.k].couple += broadcast<1>(frame(rod.slot[t.k]) * cross(t.arm, force));
}

/// Momentum of both nodes over their mass.
Vec3d element_velocity(const Rod& rod, std::size_t k) {
    const double before = rod.group.node_mass[k], after = rod.group.node_mass[k + 1];
    return (1 / (before + after)) * (before * rod.velocity(k) + after * rod.velocity(k + 1));
}

/// 1 up to the tolerated speed, 0 from twice that on.
double sticking(double speed, double tolerated) {
    return speed > tolerated ? std::abs(1 - std::min(1.0, speed / tolerated - 1)) : 1.0;
}

} // namespace

Plane read_plane(const Entry& e) { return {e["origin"].vector(), e["normal"].vector()}; }

PlaneFriction::PlaneFriction(const Entry& e)
    : has_friction(e["kind"].text() != "rod_plane"), stiffness(e["k"].number()), damping(e["nu"].number()),
      surface_tolerance(e["surface_tol"].number()) {
    e.expect_keys(
        {"kind", "system", "other", "k", "nu", "surface_tol", "slip_velocity_tol", "kinetic_mu", "static_mu"});
    if (!has_friction) return;
    slip_velocity = e["slip_velocity_tol"].positive();
    kinetic = e["kinetic_mu"].vector();
    still = e["static_mu"].vector();
}

void PlaneFriction::add(Rod& rod, const Plane& plane) const {
    const Vec3d& n = plane.normal;
    const auto segments = segments_of(rod);
    std::vector<Touch> touches;
    std::vector<Vec3d> normal_force;
    for (std::size_t k = 0; k < segments.size(); ++k) {
        const Segment& s = segments[k];
        const double height = dot(s.start + 0.5 * s.edge - plane.origin, n) - s.radius;
        if (height > surface_tolerance) continue;
        const double pressing = std::min(dot(force_on_element(rod, k), n), 0.0);
        const Vec3d v = element_velocity(rod, k), response = -pressing * n;
        normal_force.push_back(response - (stiffness * std::min(height, 0.0) + damping * dot(v, n)) * n);

        const Vec3d tangent = (1 / s.length) * s.edge, level = tangent - dot(tangent, n) * n;
        const Vec3d a = (1 / (norm(level) + 1e-14)) * level, b = cross(a, n), arm = -s.radius * n;
        const Mat3d q = frame(rod.slot[k]);
        const Vec3d turning = transpose_times(q, cross(lane(rod.slot[k].spin, 0), q * arm));
        const double axial_speed = dot(v, a), rolling_speed = dot(v, b) + dot(turning, b);
        const Vec3d slip = rolling_speed * b + axial_speed * a;
        touches.push_back({.k = k,
                           .radius = s.radius,
                           .response = norm(response),
                           .axial = a,
                           .rolling = b,
                           .arm = arm,
                           .axial_sticks = sticking(norm(axial_speed * a), slip_velocity),
                           .rolling_sticks = sticking(norm(rolling_speed * b), slip_velocity),
                           .axial_speed = axial_speed,
                           .slip = (1 / norm(add_to_all(slip, 1e-14))) * slip});
    }
    // Loads were read for all elements before the first of them acts: neighbours share nodes.
    for (std::size_t i = 0; i < touches.size(); ++i) add_to_nodes(rod, touches[i].k, normal_force[i]);
    if (!has_friction) return;

    for (const Touch& t : touches)
        add_to_nodes(rod, t.k,
                     (-(1 - t.axial_sticks) * along(kinetic, t.axial_speed) * t.response * dot(t.slip, t.axial)) *
                         t.axial);
    for (const Touch& t : touches)
        add_at_contact(rod, t, (-(1 - t.rolling_sticks) * kinetic.z * t.response * dot(t.slip, t.rolling)) * t.rolling);

    std::vector<Vec3d> force;
    for (const Touch& t : touches) force.push_back(force_on_element(rod, t.k));
    for (std::size_t i = 0; i < touches.size(); ++i) {
        const Touch& t = touches[i];
        const double pull = dot(force[i], t.axial);
        add_to_nodes(rod, t.k,
                     (-std::min(std::abs(pull), t.axial_sticks * along(still, pull) * t.response) * sign(pull)) *
                         t.axial);
    }
    for (std::size_t i = 0; i < touches.size(); ++i) {
        const Touch& t = touches[i];
        const Vec3d couple = lane(rod.internal[t.k].couple, 0) + lane(rod.external[t.k].couple, 0);
        const double turn = dot(transpose_times(frame(rod.slot[t.k]), couple), t.axial);
        const double without_slip = (2 * turn / t.radius - dot(force[i], t.rolling)) / 3;
        add_at_contact(
            rod, t,
            (std::min(std::abs(without_slip), t.rolling_sticks * still.z * t.response) * sign(without_slip)) *
                t.rolling);
    }
}

} // namespace skein::replay
