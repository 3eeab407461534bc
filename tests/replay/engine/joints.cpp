#include "joints.hpp"

#include "core/rotation.hpp"
#include "segments.hpp"

#include <cmath>

namespace skein::replay {

namespace {

Vec3d to_lab(const Rod& rod, std::size_t element, const Vec3d& body) {
    return transpose_times(lane(rod.slot[element].director, 0), body);
}
Vec3d spin(const Rod& rod, std::size_t element) { return to_lab(rod, element, lane(rod.slot[element].spin, 0)); }
void add_force(Rod& rod, std::size_t node, const Vec3d& force) { rod.external[node].force += broadcast<1>(force); }
void add_couple(Rod& rod, std::size_t element, const Vec3d& lab) {
    rod.external[element].couple += broadcast<1>(lane(rod.slot[element].director, 0) * lab);
}
Mat3d transposed(const Mat3d& c) {
    return {{c.d1.x, c.d2.x, c.d3.x}, {c.d1.y, c.d2.y, c.d3.y}, {c.d1.z, c.d2.z, c.d3.z}};
}

std::size_t place(const Entry& number, std::size_t size) {
    return static_cast<std::size_t>(number.index(static_cast<int>(size)));
}

Vec3d rounded(const Vec3d& x) {
    const auto near = [](double value) { return std::nearbyint(value * 1e12) / 1e12; };
    return {near(x.x), near(x.y), near(x.z)};
}

} // namespace

PointJoint::PointJoint(const Entry& e, const Rod& a, const Rod& b)
    : stiffness_(e["k"].number()), damping_(e["nu"].number()), node_a_(place(e["index"], a.nodes())),
      node_b_(place(e["other_index"], b.nodes())) {
    const std::string kind = e["kind"].text();
    turn_ = kind == "hinge_joint" ? Turn::hinge : kind == "fixed_joint" ? Turn::fixed : Turn::free;
    if (turn_ == Turn::free) {
        e.expect_keys({"system", "other", "index", "other_index", "k", "nu"});
        return;
    }
    element_a_ = place(e["index"], a.elements());
    element_b_ = place(e["other_index"], b.elements());
    torsional_stiffness_ = e["kt"].number();
    if (turn_ == Turn::hinge) {
        e.expect_keys({"system", "other", "index", "other_index", "k", "nu", "kt", "normal_direction"});
        const Vec3d normal = e["normal_direction"].vector();
        if (zero(normal)) e["normal_direction"].fail("has no direction");
        normal_ = unit(normal);
        return;
    }
    e.expect_keys({"system", "other", "index", "other_index", "k", "nu", "kt", "nut", "rest_rotation_matrix"});
    torsional_damping_ = e["nut"].number();
    rest_ = quaternion(transposed(e["rest_rotation_matrix"].matrix()));
}

void PointJoint::add(Rod& a, Rod& b) const {
    const Vec3d force = stiffness_ * (b.position(node_b_) - a.position(node_a_)) +
                        damping_ * (b.velocity(node_b_) - a.velocity(node_a_));
    add_force(a, node_a_, force);
    add_force(b, node_b_, -force);
    if (turn_ == Turn::free) return;
    Vec3d couple;
    if (turn_ == Turn::hinge) {
        const Vec3d tangent = to_lab(b, element_b_, {0, 0, 1});
        couple = torsional_stiffness_ * cross(tangent, -dot(tangent, normal_) * normal_);
    } else {
        const Quaternion<Pack<1>> turned = broadcast<1>(rest_) * a.slot[element_a_].director;
        const Vec3d phi = lane(relative_rotation(turned, b.slot[element_b_].director), 0);
        couple = torsional_stiffness_ * to_lab(b, element_b_, phi) -
                 torsional_damping_ * (spin(b, element_b_) - spin(a, element_a_));
    }
    add_couple(a, element_a_, -couple);
    add_couple(b, element_b_, couple);
}

SideJoint::SideJoint(const Entry& e, const Rod& a, const Rod& b)
    : stiffness_(e["k"].number()), damping_(e["nu"].number()) {
    e.expect_keys({"system", "other", "index", "other_index", "direction_one", "direction_two", "offset", "k", "nu",
                   "k_repulsive"});
    if (e.has("k_repulsive") && e["k_repulsive"].number() != 0)
        throw NotBuilt("repulsion of 'surface_joint_side_by_side' (" + e.path() +
                       ".k_repulsive)"); // published with one norm for all pairs
    const auto first = e["index"].list(), second = e["other_index"].list();
    const auto one = e["direction_one"].vectors(first.size()), two = e["direction_two"].vectors(first.size());
    const auto offset = e["offset"].numbers(first.size());
    if (second.size() != first.size()) e["other_index"].fail("does not match 'index'");
    for (std::size_t k = 0; k < first.size(); ++k)
        pairs_.push_back({place(first[k], a.elements()), place(second[k], b.elements()), one[k], two[k], offset[k]});
}

void SideJoint::add(Rod& a, Rod& b) const {
    const auto of_a = segments_of(a), of_b = segments_of(b);
    const auto arm = [](const Rod& rod, const Segment& s, std::size_t k, const Vec3d& direction, double offset) {
        const double stretch = s.length * rod.group.element[k].inv_rest_length;
        return (s.radius + 0.5 * offset / std::sqrt(stretch)) * to_lab(rod, k, direction);
    };
    const auto centre = [](const Rod& rod, std::size_t k) { return 0.5 * (rod.position(k) + rod.position(k + 1)); };
    for (const Pair& p : pairs_) {
        const Vec3d r = arm(a, of_a[p.i], p.i, p.direction_a, p.offset),
                    s = arm(b, of_b[p.j], p.j, p.direction_b, p.offset);
        const Vec3d spring = stiffness_ * rounded(centre(b, p.j) + s - centre(a, p.i) - r);
        const Vec3d half = 0.5 * (spring + damping_ * (mean_velocity(b, p.j) - mean_velocity(a, p.i)));
        for (const std::size_t node : {0, 1}) {
            add_force(a, p.i + node, half);
            add_force(b, p.j + node, -half);
        }
        add_couple(a, p.i, cross(r, spring));
        add_couple(b, p.j, cross(s, -spring));
    }
}

} // namespace skein::replay
