#include "contact/contact_limits.hpp"

#include "core/principal_axes.hpp"
#include "core/two_digits.hpp"
#include "rod/body_shape.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {

namespace {

/// Largest of |J^-1/2 (c x n)|^2 over unit vectors n.
double most_turned(const Vec3d& c, const Vec3d& inverse) {
    const Mat3d m{{0, c.z, -c.y}, {-c.z, 0, c.x}, {c.y, -c.x, 0}}; // its rows: c x of the axes
    const Vec3d &a = m.d1, &b = m.d2, &d = m.d3;
    const auto of = [&](const Vec3d& u, const Vec3d& v) { return dot(scale(inverse, u), v); };
    const Vec3d value = principal_axes({of(a, a), of(b, b), of(d, d), of(a, b), of(a, d), of(b, d)}).value;
    return std::max({value.x, value.y, value.z, 0.0});
}

ContactMobility mobility_of_surface(const BodyShape& body) {
    const Vec3d& j = body.inertia;
    const Vec3d inverse{1 / j.x, 1 / j.y, 1 / j.z};
    const double most_inverse = std::max({inverse.x, inverse.y, inverse.z});
    ContactMobility most;
    for (const BodyShape::Point& p : body.point) {
        const double turned = most_turned(p.place, inverse),
                     rim = std::sqrt(turned) + p.radius * std::sqrt(most_inverse);
        most.normal = std::max(most.normal, 1 / body.mass + turned);
        most.tangential = std::max(most.tangential, 1 / body.mass + rim * rim);
        most.diameter = std::max(most.diameter, 2 * p.radius);
    }
    most.touching = 0;
    for (const BodyShape::Part& part : body.part) most.touching += part.box ? 24 : 6;
    return most;
}

/// Mass of the lighter node of an element, kg. A ring's last node has none: it is its first.
double lighter_node(const RodGroup& group, int k) {
    const auto at = to_index(k);
    return std::min(group.node_mass[at], group.node_mass[at + 1] > 0 ? group.node_mass[at + 1] : group.node_mass[0]);
}

} // namespace

ContactMobility contact_mobility(const RodGroup& group) {
    if (!group.strained()) return mobility_of_surface(*group.body());
    ContactMobility most;
    for_each_kind(group, [&](const RodGroup& kind, double) {
        for (int k = 0; k < kind.elements(); ++k) {
            const ElementConstants& c = nth(kind.element, k);
            const double light = lighter_node(kind, k);
            const double tangential = 1 / light + c.radius * c.radius * c.inv_inertia.z;
            if (tangential > most.tangential)
                most = {.normal = 1 / light, .tangential = tangential, .diameter = most.diameter, .element = k};
            most.diameter = std::max(most.diameter, 2 * c.radius);
        }
    });
    return most;
}

double slip_mobility(const RodGroup& group) {
    if (!group.strained()) {
        const ContactMobility of = mobility_of_surface(*group.body());
        return of.touching * of.tangential;
    }
    double most = 0;
    for_each_kind(group, [&](const RodGroup& kind, double) {
        for (int k = 0; k < kind.elements(); ++k) {
            const ElementConstants& c = nth(kind.element, k);
            const double turning = std::max({c.inv_inertia.x, c.inv_inertia.y, c.inv_inertia.z});
            most = std::max(most, 1 / lighter_node(kind, k) + c.radius * c.radius * turning);
        }
    });
    return ContactMobility{}.touching * most;
}

double body_mass(const RodGroup& group) {
    if (!group.heterogeneous()) return std::accumulate(group.node_mass.begin(), group.node_mass.end(), 0.0);
    double mass = 0;
    for_each_kind(group, [&](const RodGroup& kind, double) { mass += body_mass(kind); });
    return mass / static_cast<double>(group.count());
}
double mass_at_wall(const RodGroup& group) {
    if (group.strained()) return 0.25 * body_mass(group); // 1/M + (L/2)^2/(M L^2/12), where one end meets it across
    return group.body()->mass / static_cast<double>(std::min<std::size_t>(group.body()->point.size(), 4));
}
double reduced_mass(const RodGroup& a, const RodGroup& b) { return 1 / (1 / body_mass(a) + 1 / body_mass(b)); }

double tangent_stiffness(const ContactLaw& law, double overlap) {
    return law.normal == ContactNormal::linear ? law.stiffness : 1.5 * law.stiffness * std::sqrt(overlap);
}
double tangent_damping(const ContactLaw& law, double overlap) {
    return law.normal == ContactNormal::linear ? law.damping : law.damping * std::sqrt(overlap);
}

double energy_at(const ContactLaw& law, double overlap) {
    const double linear = law.stiffness * overlap * overlap;
    return law.normal == ContactNormal::linear ? 0.5 * linear : 0.4 * linear * std::sqrt(overlap);
}
double overlap_of_energy(const ContactLaw& law, double energy) {
    return law.normal == ContactNormal::linear ? std::sqrt(2 * energy / law.stiffness)
                                               : std::pow(2.5 * energy / law.stiffness, 0.4);
}

StifferLaw stiffer_law(const ContactLaw& given, const ContactLaw& law, double effective_mass, double times) {
    const auto of_key = [](const char* key, double value, double now) {
        return StifferLaw{fmt::format("{} = {:.2g} in place of {:.4g}", key, value, now),
                          fmt::format("{}={:.2g}", key, value)};
    };
    if (given.restitution > 0 && given.resolved(effective_mass).stiffness == law.stiffness) {
        const double power = given.normal == ContactNormal::linear ? 0.5 : 0.4;
        return of_key("contact.collision_time", rounded_down(given.collision_time * std::pow(times, -power)),
                      given.collision_time);
    }
    if (given.restitution == 0 && given.stiffness == law.stiffness)
        return of_key("contact.stiffness", rounded_up(times * law.stiffness), law.stiffness);
    return {fmt::format("{:.2g} times the stiffness of their [[contact_pair]]", rounded_up(times)), {}};
}

double contact_limit(const ContactMobility& of, const ContactLaw& law, double stiffness, double damping, int touching) {
    const auto limit = [&](double k, double c, double mobility) {
        k *= touching;
        c *= touching;
        const double m = 0.5 / mobility; // two alike
        return k > 0 ? (std::sqrt(c * c + 4 * k * m) - c) / k : HUGE_VAL;
    };
    double dt = limit(stiffness, damping, of.normal);
    if (law.friction == ContactFriction::memory) {
        const double spring = law.normal == ContactNormal::linear
                                  ? stiffness
                                  : stiffness / 1.5; // k_t = kappa k sqrt(g), not its derivative
        dt = std::min(dt, limit(law.tangential_share * spring, law.tangential_damping, of.tangential));
    }
    return dt;
}

double least_slip_speed(const ContactMobility& of, const ContactLaw& law, double force, int bodies, double dt) {
    if (law.friction != ContactFriction::published) return 0;
    return dt * law.largest_kinetic() * force * bodies * of.tangential;
}

TimeLimit contact_time_limit(const RodGroup& group, const ContactLaw& law, double share) {
    const ContactMobility of = contact_mobility(group);
    const double overlap = share * of.diameter;
    return {"contact",
            contact_limit(of, law, tangent_stiffness(law, overlap), tangent_damping(law, overlap), of.touching),
            of.element};
}

} // namespace skein
